// See child_process.hpp (POSIX; Linux ends the child when its parent dies, however that happens).
#include "host/model/child_process.hpp"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>
#ifdef __linux__
#include <sys/prctl.h>
#endif

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>

#include "mortise/error.hpp"

namespace mortise::model_reader {
namespace {

constexpr std::size_t kMostOutput = std::size_t{1} << 31;
constexpr std::size_t kMostErrors = std::size_t{1} << 20;
constexpr int kNotStarted = 127;  // as shells say it

[[noreturn]] void fail_to_start(const std::string& path, int error) {
    throw Error(ExitCode::kFiles, path + ": cannot be started: " + std::strerror(error));
}

/// A pipe that other programs do not inherit.
class Pipe {
  public:
    explicit Pipe(const std::string& path) {
        if (pipe2(ends_, O_CLOEXEC) != 0) fail_to_start(path, errno);
    }
    ~Pipe() {
        close_writer();
        close(ends_[0]);
    }
    Pipe(const Pipe&) = delete;
    Pipe& operator=(const Pipe&) = delete;

    int reader() const { return ends_[0]; }
    int writer() const { return ends_[1]; }
    void close_writer() {
        if (ends_[1] >= 0) close(ends_[1]);
        ends_[1] = -1;
    }

  private:
    int ends_[2] = {-1, -1};
};

/// Ends the child, if it still runs, and takes its status: no way out of run_child leaves one behind.
class Child {
  public:
    explicit Child(pid_t process) : process_(process) {}
    ~Child() {
        if (process_ <= 0) return;
        kill(process_, SIGKILL);
        wait();
    }
    Child(const Child&) = delete;
    Child& operator=(const Child&) = delete;

    void end() const { kill(process_, SIGKILL); }
    int wait() {
        int status = 0;
        while (waitpid(process_, &status, 0) < 0 && errno == EINTR) {
        }
        process_ = -1;
        return WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
    }
    /// Whether it has ended; it can be waited for without delay then.
    bool has_ended() const {
        siginfo_t info{};
        const int outcome = waitid(P_PID, static_cast<id_t>(process_), &info, WEXITED | WNOHANG | WNOWAIT);
        // Where SIGCHLD is ignored, it is gone without a status.
        return outcome == 0 ? info.si_pid == process_ : errno == ECHILD;
    }

  private:
    pid_t process_;
};

/// In the child: only async-signal-safe calls.
[[noreturn]] void become(const char* path, char* const* words, pid_t parent, const Pipe& out,
                         const Pipe& err) {
#ifdef __linux__
    prctl(PR_SET_PDEATHSIG, SIGKILL);
#endif
    if (getppid() != parent) _exit(kNotStarted);
    const int nothing = open("/dev/null", O_RDONLY);
    if (nothing >= 0) dup2(nothing, STDIN_FILENO);
    dup2(out.writer(), STDOUT_FILENO);
    dup2(err.writer(), STDERR_FILENO);
    signal(SIGXFSZ, SIG_DFL);
    signal(SIGABRT, SIG_DFL);
    execv(path, words);
    _exit(kNotStarted);
}

/// Appends what is there to read; false at the end of the stream.
bool take(int file, std::string& text) {
    char buffer[65536];
    const ssize_t size = read(file, buffer, sizeof buffer);
    if (size < 0) return errno == EINTR || errno == EAGAIN;
    text.append(buffer, static_cast<std::size_t>(size));
    return size > 0;
}

}  // namespace

std::string find_program(const std::string& name) {
    const char* path = std::getenv("PATH");
    std::string folders = path != nullptr ? path : "/usr/local/bin:/usr/bin:/bin";
    folders += ":";
    for (std::size_t begin = 0, end; (end = folders.find(':', begin)) != std::string::npos; begin = end + 1) {
        // An empty entry is the folder at hand: nobody means that.
        if (end == begin) continue;
        const std::string file = folders.substr(begin, end - begin) + "/" + name;
        if (access(file.c_str(), X_OK) == 0) return file;
    }
    return {};
}

ChildResult run_child(const std::string& path, const std::vector<std::string>& arguments, double seconds) {
    using Clock = std::chrono::steady_clock;
    const auto end = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                        std::chrono::duration<double>(std::min(seconds, 1e6)));
    std::vector<std::string> texts = {path};
    texts.insert(texts.end(), arguments.begin(), arguments.end());
    std::vector<char*> words;
    for (std::string& text : texts) words.push_back(text.data());
    words.push_back(nullptr);

    Pipe out(path);
    Pipe err(path);
    const pid_t parent = getpid();
    const pid_t process = fork();
    if (process < 0) fail_to_start(path, errno);
    if (process == 0) become(path.c_str(), words.data(), parent, out, err);
    Child child(process);
    out.close_writer();
    err.close_writer();

    ChildResult result;
    pollfd files[2] = {{out.reader(), POLLIN, 0}, {err.reader(), POLLIN, 0}};
    while (files[0].fd >= 0 || files[1].fd >= 0 || !child.has_ended()) {
        const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - Clock::now()).count();
        if (left <= 0) {
            result.timed_out = true;
            child.end();
            break;
        }
        // Closed streams tell nothing about the end of a process: look again soon.
        const bool streams = files[0].fd >= 0 || files[1].fd >= 0;
        const auto wait = std::min<long long>(left, streams ? 200 : 5);
        if (poll(files, 2, static_cast<int>(wait)) <= 0) {
            // A process that its child left behind may keep the streams open for ever.
            if (streams && child.has_ended()) break;
            continue;
        }
        if (files[0].revents != 0 && !take(files[0].fd, result.out)) files[0].fd = -1;
        if (files[1].revents != 0 && !take(files[1].fd, result.err)) files[1].fd = -1;
        if (result.err.size() > kMostErrors) result.err.resize(kMostErrors);
        if (result.out.size() > kMostOutput) {
            throw Error(ExitCode::kInput, path + ": wrote more than 2 GiB; expected a model");
        }
    }
    result.code = child.wait();
    return result;
}

}  // namespace mortise::model_reader
