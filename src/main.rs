//! The `machband` program: opens the window or runs a command.

fn main() -> std::process::ExitCode {
    machband::cli::main()
}
