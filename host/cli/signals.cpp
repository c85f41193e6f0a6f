// See signals.hpp. Only async-signal-safe calls in the handlers.
//
// The handler of interruptions runs in the main thread only: the one that opens, writes and renames files is
// then stopped inside the handler, and cannot make a temporary file after they have been removed.
#include "host/cli/signals.hpp"

#include <pthread.h>
#include <signal.h>
#include <unistd.h>

#include "host/io/temporary_file.hpp"
#include "mortise/error.hpp"

namespace mortise::cli {
namespace {

pthread_t main_thread;
bool on_terminal = false;
bool is_silent = false;

void say(const char* message, std::size_t size) {
    const ssize_t written = write(STDERR_FILENO, message, size);
    static_cast<void>(written);
}

/// OpenCL drivers abort instead of returning an error, mostly for want of memory.
void end_aborted(int) {
    io::remove_temporary_files();
    const char message[] =
        "mortise: aborted, mostly for want of memory; use a smaller --level, or see mortise doctor\n";
    say(message, sizeof message - 1);
    _exit(static_cast<int>(ExitCode::kDevice));
}

void end(int signal_number) {
    if (pthread_equal(pthread_self(), main_thread) == 0) {
        pthread_kill(main_thread, signal_number);
        return;
    }
    io::remove_temporary_files();
    const char message[] = "\nmortise: interrupted\n";
    const std::size_t skipped = on_terminal ? 0 : 1;  // the progress line, and ^C, end with a new line
    if (!is_silent) say(message + skipped, sizeof message - 1 - skipped);
    // The signal is blocked during its own handler: it arrives again, uncaught, when this returns.
    signal(signal_number, SIG_DFL);
    raise(signal_number);
}

}  // namespace

void report_aborts() { signal(SIGABRT, end_aborted); }

void say_nothing_of_interruptions() { is_silent = true; }

void end_silently_on_signals() {
    for (const int signal_number : {SIGINT, SIGTERM, SIGHUP, SIGABRT}) signal(signal_number, SIG_DFL);
}

void end_cleanly_on_signals() {
    main_thread = pthread_self();
    on_terminal = isatty(STDERR_FILENO) != 0;
    for (const int signal_number : {SIGINT, SIGTERM, SIGHUP}) {
        struct sigaction action {};
        if (sigaction(signal_number, nullptr, &action) == 0 && action.sa_handler == SIG_IGN) continue;
        action = {};
        action.sa_handler = end;
        action.sa_flags = SA_RESTART;
        for (const int blocked : {SIGINT, SIGTERM, SIGHUP}) sigaddset(&action.sa_mask, blocked);
        sigaction(signal_number, &action, nullptr);
    }
    report_aborts();
    // A file that grows beyond `ulimit -f` is then an ordinary write error.
    signal(SIGXFSZ, SIG_IGN);
}

}  // namespace mortise::cli
