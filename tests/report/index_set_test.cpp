// Members of a set of indices and their places, against a sorted list.
#include "host/common/index_set.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <set>

#include "tests/mesher/random_source.hpp"

namespace mortise::test {

TEST_CASE("members of an index set have places in ascending order") {
    RandomSource random(12);
    for (const std::uint32_t bound : {1u, 63u, 64u, 65u, 1000u}) {
        for (const int count : {0, 1, 20, 3000}) {
            IndexSet set(bound);
            std::set<std::uint32_t> expected;
            for (int i = 0; i < count; ++i) {
                const auto index = std::min(bound - 1, static_cast<std::uint32_t>(random.uniform(0, bound)));
                set.insert(index);
                expected.insert(index);
            }
            set.number();
            CHECK(set.size() == expected.size());
            CHECK(set.members() == std::vector<std::uint32_t>(expected.begin(), expected.end()));
            std::size_t place = 0;
            for (std::uint32_t index = 0; index < bound; ++index) {
                REQUIRE(set.holds(index) == (expected.count(index) > 0));
                if (set.holds(index)) REQUIRE(set.place(index) == place++);
            }
        }
    }
}

}  // namespace mortise::test
