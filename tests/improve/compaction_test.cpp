// Arrays without some of their elements, against a loop over one at a time.
#include <doctest/doctest.h>

#include <cstdint>
#include <vector>

#include "host/common/compaction.hpp"
#include "tests/mesher/random_source.hpp"

namespace mortise::test {
namespace {

std::vector<int> expected(const std::vector<int>& values, const std::vector<std::uint8_t>& taken,
                          std::size_t stride) {
    std::vector<int> kept;
    for (std::size_t i = 0; i < values.size(); ++i) {
        if (taken[i / stride] == 0) kept.push_back(values[i]);
    }
    return kept;
}

void check(const std::vector<std::uint8_t>& taken) {
    for (const std::size_t stride : {std::size_t{1}, std::size_t{3}}) {
        std::vector<int> values(stride * taken.size());
        for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<int>(i);
        const std::vector<int> kept = expected(values, taken, stride);
        std::vector<int> changed = kept;
        for (int& value : changed) value = 7 - value;
        for (const int threads : {1, 2, 3, 8}) {
            CAPTURE(threads);
            const Compaction compaction(taken, threads);
            CHECK(compaction.is_needed() == (kept.size() < values.size()));
            std::vector<int> array = values;
            compaction.keep(array, stride);
            CHECK(array == kept);
            array = values;
            compaction.keep(array, stride, [](int value) { return 7 - value; });
            CHECK(array == changed);
        }
    }
}

}  // namespace

TEST_CASE("what stays keeps its order, whatever goes and on any threads") {
    RandomSource random(9);
    for (const std::size_t count : {0, 1, 2, 8191, 16384, 100001}) {
        CAPTURE(count);
        for (const double share : {0.0, 0.001, 0.3, 0.6, 0.99, 1.0}) {
            CAPTURE(share);
            std::vector<std::uint8_t> taken(count);
            for (auto& flag : taken) flag = random.uniform(0, 1) < share ? 1 : 0;
            check(taken);
        }
    }
    // All of the first half, and all of the second: one moves as far as the other is long.
    for (const int half : {0, 1}) {
        std::vector<std::uint8_t> taken(100000, half == 0 ? 1 : 0);
        for (std::size_t i = 50000; i < taken.size(); ++i) taken[i] = half == 0 ? 0 : 1;
        check(taken);
    }
}

}  // namespace mortise::test
