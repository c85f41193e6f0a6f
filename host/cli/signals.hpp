// Stopping on SIGINT, SIGTERM, SIGHUP and aborts without leaving a temporary file behind.
#pragma once

namespace mortise::cli {

/// Installs the handlers; call from the thread that writes all files, before any other thread starts.
///
/// A signal removes the temporary files and then ends the process as if it had not been caught, so that the
/// parent sees its true cause (a shell reports 128 + its number). Signals that the parent ignores stay
/// ignored.
void end_cleanly_on_signals();

/// Gives signals their usual effect again, for a child process that has nothing to clean up or to say.
void end_silently_on_signals();

/// For a child process whose parent is interrupted along with it: that one tells of it.
void say_nothing_of_interruptions();

/// Makes an abort one line and the exit code kDevice. Part of end_cleanly_on_signals(); to be called again
/// once a driver is open, because PoCL's compiler, LLVM, puts handlers of its own in place, and its handler
/// of aborts does not pass them on.
void report_aborts();

}  // namespace mortise::cli
