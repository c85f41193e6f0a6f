// A run that somebody watches: threads that work for it call keep_watch() now and then, at the least between
// the chunks of parallel loops, so that the caller hears of it several times a second and may stop it.
//
// Results do not depend on it: a run that is stopped has none.
#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <thread>
#include <utility>

#include "mortise/error.hpp"

namespace mortise {

class Watch {
  public:
    /// Between two questions.
    static constexpr std::chrono::milliseconds kInterval{50};

    /// Watches the work of this thread, and of those that help it, until the object goes. `ask` is called by
    /// this thread alone; false stops the run.
    explicit Watch(std::function<bool()> ask) : ask_(std::move(ask)), before_(current_) { current_ = this; }
    ~Watch() { current_ = before_; }
    Watch(const Watch&) = delete;
    Watch& operator=(const Watch&) = delete;

    /// The watch over this thread's work; null: none.
    static Watch* current() { return current_; }

    /// Puts a helping thread under a watch (null: none) while the object lives.
    class Helper {
      public:
        explicit Helper(Watch* watch) : before_(current_) { current_ = watch; }
        ~Helper() { current_ = before_; }
        Helper(const Helper&) = delete;
        Helper& operator=(const Helper&) = delete;

      private:
        Watch* before_;
    };

    /// Asks, if this is the thread to do so and it is time. Throws Interrupted if the run is to stop.
    void look() {
        if (is_stopped_) throw Interrupted();
        if (std::this_thread::get_id() != owner_) return;
        const auto now = std::chrono::steady_clock::now();
        if (now < next_) return;
        try {
            const Helper unwatched(nullptr);  // what is asked may do work of its own
            if (!ask_()) throw Interrupted();
        } catch (...) {
            is_stopped_ = true;
            throw;
        }
        next_ = std::chrono::steady_clock::now() + kInterval;
    }

  private:
    static inline thread_local Watch* current_ = nullptr;

    const std::function<bool()> ask_;
    Watch* const before_;
    const std::thread::id owner_ = std::this_thread::get_id();
    std::chrono::steady_clock::time_point next_ = std::chrono::steady_clock::now() + kInterval;
    std::atomic<bool> is_stopped_{false};
};

/// For loops that may take longer than a fraction of a second. Throws Interrupted if the run is to stop.
inline void keep_watch() {
    if (Watch* const watch = Watch::current()) watch->look();
}

}  // namespace mortise
