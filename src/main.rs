//! `machband`: arguments to window or command.

fn main() -> std::process::ExitCode {
    machband::cli::main()
}
