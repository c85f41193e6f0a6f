// Stopping on SIGINT, SIGTERM and SIGHUP without leaving a temporary file behind.
#pragma once

namespace mortise::cli {

/// Installs the handlers; call from the thread that writes all files, before any other thread starts.
///
/// A signal removes the temporary files and then ends the process as if it had not been caught, so that the
/// parent sees its true cause (a shell reports 128 + its number). Signals that the parent ignores stay
/// ignored.
void end_cleanly_on_signals();

}  // namespace mortise::cli
