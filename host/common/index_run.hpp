// Runs of consecutive indices.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace mortise {

struct IndexRun {
    std::size_t begin = 0;
    std::size_t end = 0;
};

/// Disjoint runs, ascending.
using IndexRuns = std::vector<IndexRun>;

/// Where runs of elements are when others have been taken: per element, not 0.
inline IndexRuns without(const IndexRuns& runs, const std::vector<std::uint8_t>& taken) {
    IndexRuns result;
    std::size_t at = 0, gone = 0;
    const auto pass = [&](std::size_t to) {
        const auto index = [&](std::size_t i) { return taken.begin() + static_cast<std::ptrdiff_t>(i); };
        gone += static_cast<std::size_t>(std::count(index(at), index(to), 1));
        at = to;
        return at - gone;
    };
    for (const IndexRun& run : runs) {
        const std::size_t begin = pass(run.begin), end = pass(run.end);
        if (begin < end) result.push_back({begin, end});
    }
    return result;
}

/// Looks indices up, in ascending order from `first` on.
class RunFinder {
  public:
    RunFinder(const IndexRuns& runs, std::size_t first)
        : run_(std::partition_point(runs.begin(), runs.end(),
                                    [first](const IndexRun& run) { return run.end <= first; })),
          last_(runs.end()) {}

    /// The run that an index is in; null: none.
    const IndexRun* run_of(std::size_t index) {
        while (run_ != last_ && run_->end <= index) ++run_;
        return run_ != last_ && run_->begin <= index ? &*run_ : nullptr;
    }

  private:
    IndexRuns::const_iterator run_, last_;
};

}  // namespace mortise
