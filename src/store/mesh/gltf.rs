//! Reads glTF 2.0 files, as text (`.gltf`) and in binary (`.glb`).
//!
//! The reader uses every triangle of the default scene, under the transformations of its nodes: positions, normals,
//! colors (`COLOR_0`), and the base color of the material with its texture coordinates. Animations, skins, morph targets,
//! points, lines, normal maps, transparency, other scenes and other extensions are ignored and named; cameras and everything
//! else about materials are ignored. Textures are interpolated.

use std::{
    collections::{BTreeSet, HashMap, HashSet},
    io::Cursor,
    path::{Component, Path},
    sync::Arc,
};

use ::image::{DynamicImage, ImageDecoder as _, ImageError, ImageFormat, ImageReader, RgbImage};
use base64::{Engine as _, prelude::BASE64_STANDARD};
use glam::{DAffine2, DMat3, DMat4, DVec2, DVec3};
use gltf::{
    Accessor, Document, Gltf, Primitive, Semantic,
    accessor::DataType,
    buffer, image,
    json::{self, validation::Checked},
    material::AlphaMode,
    mesh::Mode,
};
use percent_encoding::percent_decode_str;

use super::{
    MAX_FILE,
    faces::{Faces, strip_triangles},
};
use crate::{
    light::Transfer,
    shading::{
        PaintedCorner, Texture,
        mesh::{Corner, MAX_COORDINATE},
    },
    store::{file::read_bytes, table::shortened},
};

/// Maximum number of texels of all textures of a mesh, as many as 4096 × 4096: each needs 12 bytes.
const MAX_TEXELS: usize = 1 << 24;

/// Maximum number of triangles: nodes can repeat a mesh any number of times.
const MAX_TRIANGLES: usize = 4_000_000;

/// The extensions that this reader knows.
const KNOWN: [&str; 2] = ["KHR_mesh_quantization", "KHR_texture_transform"];

/// Reads the content of a glTF or GLB file. Other files that it names must lie in `folder`. With `is_flat`, faces without
/// normals get their own, as the specification says.
///
/// # Errors
/// Content that is not glTF, data that are missing or out of range, and coordinates that are not finite.
pub(super) fn parse(folder: Option<&Path>, content: &[u8], is_flat: bool) -> Result<Faces, String> {
    // The header has 12 bytes, and its last four count them as well; the crate relies on that.
    if content.starts_with(b"glTF") {
        let length = content.get(8..12).map(|bytes| u32::from_le_bytes(bytes.try_into().unwrap_or_default()));
        let length = length.filter(|length| *length >= 12).ok_or("its header is damaged; expected a GLB file")?;
        if content.len() < length as usize {
            return Err(format!("ends after {} bytes; expected {length}, as its header says", content.len()));
        }
    }
    let not_gltf =
        |error: gltf::Error| format!("{}; expected a glTF 2.0 file", error.to_string().trim_end_matches(';'));
    let Gltf { document, mut blob } = Gltf::from_slice_without_validation(content).map_err(not_gltf)?;
    let mut json = document.into_json();
    let version = json.asset.min_version.as_ref().unwrap_or(&json.asset.version);
    if version != "2.0" && (json.asset.min_version.is_some() || !version.starts_with("2.")) {
        return Err(format!("is glTF {version}; expected glTF 2.0"));
    }
    // Applications may have attributes of their own.
    for primitive in json.meshes.iter_mut().flat_map(|mesh| &mut mesh.primitives) {
        primitive.attributes.retain(|name, _| matches!(name, Checked::Valid(_)));
    }
    // A required extension says more than what is missing without it.
    let ignored = extensions(&mut json)?;
    check(&json)?;
    let document = Document::from_json(json).map_err(not_gltf)?;
    let left = MAX_FILE.saturating_sub(content.len() as u64);
    let mut reader = Reader { folder, left, texels: MAX_TEXELS, ..Reader::default() };
    reader.faces.is_flat = is_flat;
    for buffer in document.buffers() {
        let bytes = match buffer.source() {
            buffer::Source::Bin => blob.take().ok_or("its binary chunk is missing; expected one, for one buffer")?,
            buffer::Source::Uri(uri) => reader.at(uri)?,
        };
        reader.buffers.push(bytes);
    }
    reader.document(&document)?;
    let mut faces = reader.faces;
    if !ignored.is_empty() {
        faces.notes.push(format!("extensions were ignored: {}", ignored.join(", ")));
    }
    Ok(faces)
}

/// Checks the extensions that a file requires, and returns the names of those that are ignored.
fn extensions(json: &mut json::Root) -> Result<Vec<String>, String> {
    let named = json.extensions_used.iter().chain(&json.extensions_required);
    let ignored: BTreeSet<_> = named.filter(|name| !KNOWN.contains(&name.as_str())).cloned().collect();
    let required = &mut json.extensions_required;
    // The crate does not know that these are read. Of materials, only the base color counts.
    required.retain(|name| !KNOWN.contains(&name.as_str()) && !name.starts_with("KHR_materials_"));
    if !required.is_empty() {
        let names = required.join(", ");
        return Err(format!(
            "it requires extensions that are not read ({names}); expected {} or none, as \"gltf-transform copy in.glb out.glb\" writes compressed meshes",
            KNOWN.join(", ")
        ));
    }
    Ok(ignored.into_iter().collect())
}

/// Checks what the crate takes for granted, even when it validates.
fn check(json: &json::Root) -> Result<(), String> {
    let position = Checked::Valid(Semantic::Positions);
    let primitives = json.meshes.iter().enumerate().flat_map(|(i, mesh)| mesh.primitives.iter().map(move |p| (i, p)));
    for (mesh, primitive) in primitives {
        if primitive.attributes.get(&position).is_some_and(|accessor| accessor.value() >= json.accessors.len()) {
            return Err(format!("mesh {mesh} has positions that do not exist; expected the index of an accessor"));
        }
    }
    for (i, image) in json.images.iter().enumerate() {
        if image.uri.is_none() && (image.buffer_view.is_none() || image.mime_type.is_none()) {
            return Err(format!("image {i} has no content; expected a URI, or a buffer view and its MIME type"));
        }
    }
    Ok(())
}

#[derive(Default)]
struct Reader<'a> {
    folder: Option<&'a Path>,
    /// The bytes that the file refers to.
    buffers: Vec<Vec<u8>>,
    /// The number of bytes that other files may still have.
    left: u64,
    faces: Faces,
    /// The index of the coat that has each texture, or none.
    coats: HashMap<Option<usize>, u32>,
    /// The number of texels that textures may still have.
    texels: usize,
}

impl Reader<'_> {
    /// Returns the content of a URI: data, or a file in the folder.
    fn at(&mut self, uri: &str) -> Result<Vec<u8>, String> {
        if let Some(data) = uri.strip_prefix("data:") {
            let text = data.split_once(";base64,").ok_or("its data are not in base64; expected base64")?.1;
            return BASE64_STANDARD
                .decode(text)
                .map_err(|error| format!("its data are not in base64 ({error}); expected base64"));
        }
        let name = percent_decode_str(uri).decode_utf8_lossy();
        let is_below = |part: Component<'_>| matches!(part, Component::Normal(_) | Component::CurDir);
        let is_plain = !name.contains(':') && Path::new(&*name).components().all(is_below);
        match self.folder.filter(|_| is_plain) {
            Some(folder) => {
                let bytes = read_bytes(&folder.join(&*name), self.left, "a file that the mesh refers to")
                    .map_err(|error| error.to_string())?;
                self.left -= bytes.len() as u64;
                Ok(bytes)
            }
            None => Err(format!("refers to {:?}; expected a file in the same folder or below", shortened(uri))),
        }
    }

    fn view(&self, view: &buffer::View<'_>) -> Result<&[u8], String> {
        let end = view.offset().checked_add(view.length());
        let buffer = self.buffers.get(view.buffer().index());
        let bytes = end.and_then(|end| buffer?.get(view.offset()..end));
        bytes.ok_or_else(|| format!("buffer view {} reaches beyond its buffer; expected one within it", view.index()))
    }

    /// Returns what [`Reader::numbers`] does if that is one item for each of `count` positions.
    fn each<const N: usize>(&self, accessor: &Accessor<'_>, what: &str, count: usize) -> Result<Vec<[f64; N]>, String> {
        let numbers = self.numbers(accessor, what)?;
        let found = numbers.len();
        let wrong = || format!("it has {count} positions and {found} {what}; expected the same number");
        (found == count).then_some(numbers).ok_or_else(wrong)
    }

    /// Returns the `N` numbers of each item of an accessor; normalized integers become −1…1.
    fn numbers<const N: usize>(&self, accessor: &Accessor<'_>, what: &str) -> Result<Vec<[f64; N]>, String> {
        let (index, size) = (accessor.index(), accessor.data_type().size());
        let given = accessor.dimensions().multiplicity();
        if given < N {
            return Err(format!("its {what} (accessor {index}) have {given} numbers each; expected {N}"));
        }
        let (kind, is_normalized) = (accessor.data_type(), accessor.normalized());
        let number = |bytes: &[u8]| {
            let (value, full) = match (kind, bytes) {
                (DataType::F32, &[a, b, c, d]) => return f64::from(f32::from_le_bytes([a, b, c, d])),
                (DataType::U32, &[a, b, c, d]) => return f64::from(u32::from_le_bytes([a, b, c, d])),
                (DataType::U16, &[a, b]) => (f64::from(u16::from_le_bytes([a, b])), 65_535.0),
                (DataType::I16, &[a, b]) => (f64::from(i16::from_le_bytes([a, b])), 32_767.0),
                (DataType::I8, &[a]) => (f64::from(a as i8), 127.0),
                (_, bytes) => (f64::from(bytes[0]), 255.0),
            };
            if is_normalized { (value / full).max(-1.0) } else { value }
        };
        let dense = accessor.view().filter(|_| accessor.sparse().is_none());
        let view = dense.ok_or_else(|| {
            format!("its {what} (accessor {index}) are sparse, compressed or missing; expected them in a buffer view")
        })?;
        let (from, stride, count) = (accessor.offset(), view.stride().unwrap_or(size * given), accessor.count());
        let end = count.checked_sub(1).and_then(|last| last.checked_mul(stride)?.checked_add(size * given));
        let bytes = self.view(&view)?;
        let bytes = end.and_then(|end| bytes.get(from..from.checked_add(end)?)).ok_or_else(|| {
            format!("its {what} (accessor {index}) reach beyond their buffer view; expected them within it")
        })?;
        let item = |at: usize| std::array::from_fn(|k| number(&bytes[at * stride + k * size..][..size]));
        Ok((0..count).map(item).collect())
    }

    fn document(&mut self, document: &Document) -> Result<(), String> {
        let scene = document.default_scene().or_else(|| document.scenes().next());
        let others = (document.scenes().len() > 1).then_some("scenes other than the default one were ignored");
        let moves = (document.animations().len() > 0).then_some("animations were ignored");
        self.faces.ignored.extend(others.into_iter().chain(moves));
        let roots: Vec<_> = match scene {
            Some(scene) => scene.nodes().collect(),
            None => {
                let children = document.as_json().nodes.iter().flat_map(|node| node.children.iter().flatten());
                let children: HashSet<usize> = children.map(|child| child.value()).collect();
                document.nodes().filter(|node| !children.contains(&node.index())).collect()
            }
        };
        let mut waiting: Vec<_> = roots.into_iter().map(|node| (node, DMat4::IDENTITY)).collect();
        let mut seen = vec![false; document.nodes().len()];
        while let Some((node, above)) = waiting.pop() {
            if std::mem::replace(&mut seen[node.index()], true) {
                return Err(format!("node {} has two parents; expected a tree", node.index()));
            }
            let columns = node.transform().matrix().map(|column| column.map(f64::from));
            let placed = above * DMat4::from_cols_array_2d(&columns);
            if let Some(mesh) = node.mesh() {
                let weights = node.weights().or(mesh.weights()).unwrap_or_default();
                if weights.iter().any(|weight| *weight != 0.0) {
                    self.faces.ignored.insert("morph targets were ignored");
                }
                if node.skin().is_some() {
                    self.faces.ignored.insert("skins were ignored");
                }
                for primitive in mesh.primitives() {
                    let (index, part) = (mesh.index(), primitive.index());
                    self.primitive(&primitive, placed)
                        .map_err(|error| format!("mesh {index}, primitive {part}: {error}"))?;
                }
            }
            waiting.extend(node.children().map(|child| (child, placed)));
        }
        Ok(())
    }

    fn primitive(&mut self, primitive: &Primitive<'_>, placed: DMat4) -> Result<(), String> {
        let mode = primitive.mode();
        if !matches!(mode, Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
            self.faces.ignored.insert("points and lines were ignored");
            return Ok(());
        }
        let get = |semantic: Semantic| primitive.get(&semantic);
        let positions = get(Semantic::Positions).ok_or("it has no positions; expected POSITION")?;
        let positions = self.numbers::<3>(&positions, "positions")?;
        let count = positions.len();
        let normals = get(Semantic::Normals).map(|normals| self.each::<3>(&normals, "normals", count));
        let normals = normals.transpose()?;
        let corners = self.corners(primitive, count)?;
        if mode == Mode::Triangles && corners.len() % 3 != 0 {
            return Err(format!("its triangles have {} corners; expected a multiple of 3", corners.len()));
        }
        let triangles = triangles(mode, &corners);
        if self.faces.polygons.ends.len() + triangles.len() > MAX_TRIANGLES {
            return Err(format!("the file has more than {MAX_TRIANGLES} triangles; expected at most as many"));
        }

        let linear = DMat3::from_mat4(placed);
        let (side, of_normals) = (linear.determinant().signum(), linear.inverse().transpose());
        let polygons = &mut self.faces.polygons;
        let first = polygons.positions.len();
        for (i, position) in positions.into_iter().enumerate() {
            let position = placed.transform_point3(DVec3::from_array(position));
            // NaN does not count as within.
            if !position.to_array().iter().all(|x| x.abs() <= MAX_COORDINATE) {
                return Err(format!("position {i} is not finite or is beyond ±1e30; expected three finite numbers"));
            }
            polygons.positions.push(position);
        }
        let normal = |normal| (of_normals * DVec3::from_array(normal)).try_normalize();
        polygons.normals.extend(normals.unwrap_or_default().into_iter().map(normal));
        polygons.normals.resize(first + count, None);
        let texture = self.paint(primitive, count)?;
        let coat = self.coat(texture)?;
        for [a, b, c] in triangles {
            // A transformation that mirrors also reverses the winding.
            let corners = if side < 0.0 { [a, c, b] } else { [a, b, c] };
            self.faces.polygons.push(corners.map(|corner| Corner::of((first + corner) as u32)));
            self.faces.polygons.of_polygons.push(coat);
        }
        Ok(())
    }

    /// Adds the paint of a primitive's vertices: their colors, and their places in its texture, which is returned if they
    /// have such places.
    fn paint<'p>(&mut self, primitive: &Primitive<'p>, count: usize) -> Result<Option<gltf::Texture<'p>>, String> {
        let material = primitive.material();
        if material.alpha_mode() != AlphaMode::Opaque {
            self.faces.ignored.insert("transparency was ignored");
        }
        if material.normal_texture().is_some() {
            self.faces.ignored.insert("normal maps were ignored");
        }
        let base = material.pbr_metallic_roughness();
        let [r, g, b, _] = base.base_color_factor().map(f64::from);
        let colors = match primitive.get(&Semantic::Colors(0)) {
            Some(colors) => self.each::<3>(&colors, "colors", count)?,
            None => vec![[1.0; 3]; count],
        };
        let first = self.faces.polygons.paint.len();
        self.faces.polygons.paint.extend(colors.into_iter().map(|color| {
            let color = DVec3::from_array(color) * DVec3::new(r, g, b);
            let color = if color.is_finite() { color.clamp(DVec3::ZERO, DVec3::ONE) } else { DVec3::ONE };
            PaintedCorner { color, ..PaintedCorner::default() }
        }));
        // An extension may give a texture another image, which is ignored like the extension.
        let Some(base) = base.base_color_texture().filter(|base| base.texture().source().is_some()) else {
            return Ok(None);
        };
        let place = base.texture_transform();
        let set = place.as_ref().and_then(|place| place.tex_coord()).unwrap_or(base.tex_coord());
        let placed = place.map_or(DAffine2::IDENTITY, |place| {
            let two = |of: [f32; 2]| DVec2::from_array(of.map(f64::from));
            // The angle turns the image clockwise, and v points down.
            DAffine2::from_scale_angle_translation(
                two(place.scale()),
                -f64::from(place.rotation()),
                two(place.offset()),
            )
        });
        let Some(places) = primitive.get(&Semantic::TexCoords(set)) else {
            self.faces.ignored.insert("textures without texture coordinates were ignored");
            return Ok(None);
        };
        let places = self.each::<2>(&places, "texture coordinates", count)?;
        for (vertex, place) in self.faces.polygons.paint[first..].iter_mut().zip(places) {
            vertex.place = placed.transform_point2(DVec2::from_array(place));
        }
        Ok(Some(base.texture()))
    }

    /// Returns the vertex of each corner of a primitive with `count` vertices.
    fn corners(&self, primitive: &Primitive<'_>, count: usize) -> Result<Vec<usize>, String> {
        let Some(indices) = primitive.indices() else { return Ok((0..count).collect()) };
        let indices = self.numbers::<1>(&indices, "indices")?;
        let corner = |[index]: [f64; 1]| {
            let corner = Some(index as usize).filter(|corner| *corner < count && index >= 0.0);
            corner.ok_or_else(|| format!("an index is {index}; expected 0…{}", count.saturating_sub(1)))
        };
        indices.into_iter().map(corner).collect()
    }

    /// Returns the index of the coat that has this texture.
    fn coat(&mut self, texture: Option<gltf::Texture<'_>>) -> Result<u32, String> {
        let key = texture.as_ref().map(gltf::Texture::index);
        if let Some(known) = self.coats.get(&key) {
            return Ok(*known);
        }
        let coat = texture.map(|texture| self.texture(&texture)).transpose()?;
        let coats = &mut self.faces.polygons.coats;
        coats.push(coat);
        let index = coats.len() as u32 - 1;
        self.coats.insert(key, index);
        Ok(index)
    }

    fn texture(&mut self, texture: &gltf::Texture<'_>) -> Result<Arc<Texture>, String> {
        let image = texture.source().ok_or("a texture has no image; expected one")?;
        let read;
        let bytes = match image.source() {
            image::Source::View { view, .. } => self.view(&view)?,
            image::Source::Uri { uri, .. } => {
                read = self.at(uri)?;
                &read
            }
        };
        let pixels = decoded(bytes, self.texels).map_err(|error| format!("image {} {error}", image.index()))?;
        self.texels -= pixels.pixels().len();
        let light = |code: u8| Transfer::Srgb.linear_from_encoded(f64::from(code) / 255.0) as f32;
        let lights: [f32; 256] = std::array::from_fn(|code| light(code as u8));
        let texels = pixels.pixels().map(|pixel| pixel.0.map(|code| lights[usize::from(code)])).collect();
        let wrap = [texture.sampler().wrap_s(), texture.sampler().wrap_t()];
        Ok(Arc::new(Texture { width: pixels.width(), height: pixels.height(), texels, wrap }))
    }
}

/// Returns the corners of each triangle.
fn triangles(mode: Mode, corners: &[usize]) -> Vec<[usize; 3]> {
    match mode {
        Mode::Triangles => corners.as_chunks().0.to_vec(),
        Mode::TriangleStrip => strip_triangles(corners),
        _ => corners.windows(2).skip(1).map(|pair| [corners[0], pair[0], pair[1]]).collect(),
    }
}

/// Decodes a PNG or JPEG image of at most `most` pixels.
///
/// # Errors
/// A sentence without its subject: the content is of neither format, is damaged or has too many pixels.
fn decoded(content: &[u8], most: usize) -> Result<RgbImage, String> {
    let Ok(format @ (ImageFormat::Png | ImageFormat::Jpeg)) = ::image::guess_format(content) else {
        return Err("is neither a PNG nor a JPEG image; expected one of them".to_owned());
    };
    let damaged = |error: ImageError| format!("is damaged ({error}); expected a PNG or JPEG image");
    let decoder = ImageReader::with_format(Cursor::new(content), format).into_decoder().map_err(damaged)?;
    let (width, height) = decoder.dimensions();
    if u64::from(width) * u64::from(height) > most as u64 {
        return Err(format!("has {width} × {height} pixels; expected at most {MAX_TEXELS} in all images together"));
    }
    Ok(DynamicImage::from_decoder(decoder).map_err(damaged)?.into_rgb8())
}
