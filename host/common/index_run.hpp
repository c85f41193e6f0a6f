// Runs of consecutive indices.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace mortise {

struct IndexRun {
    std::size_t begin = 0;
    std::size_t end = 0;
};

/// Disjoint runs, ascending.
using IndexRuns = std::vector<IndexRun>;

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
