#!/usr/bin/env bash
# Builds a Debian package of the program: scripts/deb.sh [FOLDER]
#
# The package has the program, a man page for each command, completions for bash, fish and zsh, and an entry with an icon
# in the desktop's menu. It runs on this version of Debian or newer. Needs Rust, gcc and dpkg-deb, and about ten minutes.
# With PROGRAMS=FOLDER, packages the programs `machband` and `tools` in that folder instead of building them.
set -euo pipefail
cd "$(dirname "$0")/.."
out=$(realpath -m "${1:-target/debian}")
if [ -z "${PROGRAMS:-}" ]; then
    cargo build --locked --profile dist -p machband -p tools
    PROGRAMS=${CARGO_TARGET_DIR:-target}/dist
fi
version=$("$PROGRAMS/machband" --version | cut -d ' ' -f 2)
architecture=$(dpkg --print-architecture)
glibc=$(objdump -T "$PROGRAMS/machband" | grep -o 'GLIBC_[0-9.]*' | sort -uV | tail -1 | cut -d _ -f 2)

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
root=$work/root
"$PROGRAMS/tools" package "$work"
install -D -m 755 "$PROGRAMS/machband" "$root/usr/bin/machband"
for page in "$work"/man1/*.1; do
    gzip -9n "$page"
    install -D -m 644 "$page.gz" "$root/usr/share/man/man1/$(basename "$page").gz"
done
install -D -m 644 "$work/completions/machband.bash" "$root/usr/share/bash-completion/completions/machband"
install -D -m 644 "$work/completions/machband.fish" "$root/usr/share/fish/vendor_completions.d/machband.fish"
install -D -m 644 "$work/completions/_machband" "$root/usr/share/zsh/vendor-completions/_machband"
install -D -m 644 "$work/machband.png" "$root/usr/share/icons/hicolor/128x128/apps/machband.png"
install -D -m 644 LICENSE-MIT "$root/usr/share/doc/machband/copyright"
gzip -9nc CHANGELOG.md >"$work/changelog.gz"
install -D -m 644 "$work/changelog.gz" "$root/usr/share/doc/machband/changelog.gz"
mkdir -p "$root/usr/share/applications" "$root/DEBIAN"
cat >"$root/usr/share/applications/machband.desktop" <<'DESKTOP'
[Desktop Entry]
Type=Application
Name=machband
Comment=Measure how visible Mach bands are
Exec=machband
Icon=machband
Categories=Science;Education;
Keywords=psychophysics;vision;perception;stimulus;experiment;
Terminal=false
StartupWMClass=machband
DESKTOP
cat >"$root/DEBIAN/control" <<CONTROL
Package: machband
Version: $version
Architecture: $architecture
Maintainer: machband maintainers <maintainers@machband.invalid>
Installed-Size: $(du -sk "$root/usr" | cut -f 1)
Depends: libc6 (>= $glibc), libgcc-s1
Recommends: libgl1, libegl1, libgl1-mesa-dri, libx11-xcb1, libxcursor1, libxi6, libxkbcommon-x11-0
Suggests: mesa-vulkan-drivers, fonts-noto-cjk
Section: science
Priority: optional
Description: measure, analyze, generate and predict the visibility of Mach bands
 Mach bands are the bright and dark lines that people see where the slope of
 luminance changes. machband runs experiments that measure how visible they
 are, analyzes the ratings, writes exact stimuli, predicts visibility with a
 model of early vision, and compares shaders that avoid the bands.
CONTROL
mkdir -p "$out"
dpkg-deb --build --root-owner-group "$root" "$out/machband_${version}_$architecture.deb"
