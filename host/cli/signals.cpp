// See signals.hpp. Only async-signal-safe calls in the handler.
//
// The handler runs in the main thread only: the one that opens, writes and renames files is then stopped
// inside the handler, and cannot make a temporary file after they have been removed.
#include "host/cli/signals.hpp"

#include <pthread.h>
#include <signal.h>
#include <unistd.h>

#include "host/io/temporary_file.hpp"

namespace mortise::cli {
namespace {

pthread_t main_thread;
bool on_terminal = false;

void end(int signal_number) {
    if (pthread_equal(pthread_self(), main_thread) == 0) {
        pthread_kill(main_thread, signal_number);
        return;
    }
    io::remove_temporary_files();
    const char message[] = "\nmortise: interrupted\n";
    const std::size_t skipped = on_terminal ? 0 : 1;  // the progress line, and ^C, end with a new line
    const ssize_t written = write(STDERR_FILENO, message + skipped, sizeof message - 1 - skipped);
    static_cast<void>(written);
    // The signal is blocked during its own handler: it arrives again, uncaught, when this returns.
    signal(signal_number, SIG_DFL);
    raise(signal_number);
}

}  // namespace

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
}

}  // namespace mortise::cli
