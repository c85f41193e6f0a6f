#include "host/cli/worker_pool.hpp"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <new>
#include <vector>

#include "mortise/error.hpp"

namespace mortise::cli {
namespace {

constexpr std::uint64_t kIdle = ~std::uint64_t{0};

/// In memory that parent and children share, before the items at hand, one per worker.
struct Shared {
    std::atomic<std::uint64_t> next{0};
};
using AtHand = std::atomic<std::uint64_t>;
static_assert(sizeof(Shared) % alignof(AtHand) == 0 && AtHand::is_always_lock_free);

struct Worker {
    pid_t process = -1;
    int pipe = -1;
    std::string received;
};

struct Header {
    std::uint64_t item;
    std::uint64_t length;
};

void write_all(int file, const void* data, std::size_t size) {
    const char* at = static_cast<const char*>(data);
    while (size > 0) {
        const ssize_t written = write(file, at, size);
        if (written < 0 && errno == EINTR) continue;
        if (written <= 0) _exit(static_cast<int>(ExitCode::kFiles));  // the parent is gone
        at += written;
        size -= static_cast<std::size_t>(written);
    }
}

class Pool {
  public:
    Pool(std::size_t count, std::size_t jobs, const std::function<std::string(std::size_t)>& work,
         const std::function<void(std::size_t, std::string, int)>& done)
        : count_(count), work_(work), done_(done), workers_(jobs), is_done_(count, false) {
        bytes_ = sizeof(Shared) + jobs * sizeof(AtHand);
        void* memory = mmap(nullptr, bytes_, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
        if (memory == MAP_FAILED) throw std::bad_alloc();
        shared_ = new (memory) Shared;
        at_hand_ = reinterpret_cast<AtHand*>(static_cast<char*>(memory) + sizeof(Shared));
        for (std::size_t w = 0; w < jobs; ++w) new (at_hand_ + w) AtHand(kIdle);
    }
    ~Pool() {
        for (const Worker& worker : workers_) {
            if (worker.process <= 0) continue;
            kill(worker.process, SIGTERM);
            waitpid(worker.process, nullptr, 0);
        }
        munmap(static_cast<void*>(shared_), bytes_);
    }
    Pool(const Pool&) = delete;
    Pool& operator=(const Pool&) = delete;

    void run() {
        for (std::size_t w = 0; w < workers_.size(); ++w) start(w);
        std::vector<pollfd> files(workers_.size());
        while (is_anyone_at_work()) {
            for (std::size_t w = 0; w < workers_.size(); ++w) files[w] = {workers_[w].pipe, POLLIN, 0};
            if (poll(files.data(), files.size(), -1) < 0 && errno != EINTR)
                throw Error(ExitCode::kFiles, std::string("no results: ") + std::strerror(errno));
            for (std::size_t w = 0; w < workers_.size(); ++w) {
                if ((files[w].revents & (POLLIN | POLLHUP)) != 0) receive(w);
            }
        }
        // A worker may end between taking an item and saying so.
        for (std::size_t i = 0; i < count_; ++i) finish(i, {}, last_end_);
    }

  private:
    bool is_anyone_at_work() const {
        return std::any_of(workers_.begin(), workers_.end(), [](const Worker& w) { return w.pipe >= 0; });
    }

    void start(std::size_t w) {
        int ends[2];
        // What a worker starts (OpenSCAD) must not hold its pipe open: its end is how this process knows of
        // it.
        if (pipe2(ends, O_CLOEXEC) != 0)
            throw Error(ExitCode::kFiles, std::string("no pipe: ") + std::strerror(errno));
        const pid_t parent = getpid();
        const pid_t process = fork();
        if (process < 0) {
            close(ends[0]);
            close(ends[1]);
            throw Error(ExitCode::kFiles, std::string("no process: ") + std::strerror(errno));
        }
        if (process == 0) {
            prctl(PR_SET_PDEATHSIG, SIGTERM);
            if (getppid() != parent) _exit(0);  // it has ended before it was asked for
            close(ends[0]);
            for (const Worker& other : workers_) {
                if (other.pipe >= 0) close(other.pipe);
            }
            serve(w, ends[1]);
        }
        close(ends[1]);
        workers_[w] = {process, ends[0], {}};
    }

    /// Never returns or throws: what is on the stack below belongs to the parent, and undoing it would end
    /// the other workers.
    [[noreturn]] void serve(std::size_t w, int file) noexcept {
        try {
            for (std::uint64_t item = shared_->next++; item < count_; item = shared_->next++) {
                at_hand_[w] = item;
                const std::string result = work_(static_cast<std::size_t>(item));
                const Header header{item, result.size()};
                write_all(file, &header, sizeof header);
                write_all(file, result.data(), result.size());
                at_hand_[w] = kIdle;
            }
        } catch (...) {
            _exit(static_cast<int>(ExitCode::kDevice));  // out of memory, where not even that can be told
        }
        _exit(0);
    }

    void receive(std::size_t w) {
        Worker& worker = workers_[w];
        char buffer[65536];
        const ssize_t size = read(worker.pipe, buffer, sizeof buffer);
        if (size < 0 && errno == EINTR) return;
        if (size > 0) {
            worker.received.append(buffer, static_cast<std::size_t>(size));
            take_results(worker);
            return;
        }
        close(worker.pipe);
        int status = 0;
        while (waitpid(worker.process, &status, 0) < 0 && errno == EINTR) {
        }
        const std::uint64_t item = at_hand_[w].exchange(kIdle);
        const bool complete = worker.received.empty();
        worker = Worker{};
        const int end = WIFSIGNALED(status) ? WTERMSIG(status) : -WEXITSTATUS(status);
        if (item == kIdle && complete && end == 0) return;
        last_end_ = end;
        if (item != kIdle) finish(static_cast<std::size_t>(item), {}, end);
        if (shared_->next >= count_) return;
        try {
            start(w);
        } catch (const Error&) {
            if (!is_anyone_at_work()) throw;  // else the others do what is left
        }
    }

    void take_results(Worker& worker) {
        for (;;) {
            Header header;
            if (worker.received.size() < sizeof header) return;
            std::memcpy(&header, worker.received.data(), sizeof header);
            if (worker.received.size() - sizeof header < header.length) return;
            std::string result = worker.received.substr(sizeof header, header.length);
            worker.received.erase(0, sizeof header + header.length);
            finish(static_cast<std::size_t>(header.item), std::move(result), 0);
        }
    }

    /// Once for each item: a worker may end after its result, before it takes the next one.
    void finish(std::size_t item, std::string result, int end) {
        if (is_done_[item]) return;
        is_done_[item] = true;
        done_(item, std::move(result), end);
    }

    std::size_t count_;
    const std::function<std::string(std::size_t)>& work_;
    const std::function<void(std::size_t, std::string, int)>& done_;
    std::vector<Worker> workers_;
    std::vector<bool> is_done_;  ///< per item
    int last_end_ = 0;           ///< of the worker that ended last without being done
    Shared* shared_ = nullptr;
    AtHand* at_hand_ = nullptr;
    std::size_t bytes_ = 0;
};

}  // namespace

void run_in_processes(std::size_t count, std::size_t jobs,
                      const std::function<std::string(std::size_t)>& work,
                      const std::function<void(std::size_t, std::string, int)>& done) {
    Pool(count, jobs, work, done).run();
}

}  // namespace mortise::cli
