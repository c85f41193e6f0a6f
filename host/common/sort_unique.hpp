// Lists as sets: ascending, each value once.
#pragma once

#include <algorithm>

namespace mortise {

/// Sorts the list and leaves each value once.
template <class List>
void sort_unique(List& list) {
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
}

}  // namespace mortise
