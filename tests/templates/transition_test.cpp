// The committed table of transition cells is the generator's.
#include <doctest/doctest.h>

#include <fstream>
#include <iterator>
#include <string>

#include "host/templates/transition.hpp"

using namespace mortise;
using namespace mortise::templates;

TEST_CASE("transition cells: the generator reproduces the committed table byte for byte, proved") {
    const auto classes = build_transitions();
    CHECK(classes.size() == 227);  // 6,210 patterns under 48 symmetries
    for (const TransitionClass& row : classes) {
        CAPTURE(row.pattern);
        CHECK(row.is_fewest);
    }
    std::ifstream file(MORTISE_TRANSITION_TABLE, std::ios::binary);
    REQUIRE(file.good());
    const std::string committed{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
    const bool same = committed == transition_text(classes);
    CHECK_MESSAGE(same, "host/cnio/transition_table.hpp is out of date: run generate_transitions on it");
}

TEST_CASE("transition cells: the cone from the centre keeps the limits, so every class has a template") {
    for (SplitPattern pattern = 0; pattern < 1u << kSplitBits; ++pattern) {
        if (!is_split_pattern(pattern)) continue;
        CAPTURE(pattern);
        int volume = 0;
        for (const TransitionElement& element : transition_cone(pattern)) {
            const TransitionFigures figures = transition_figures(element);
            CHECK(figures.scaled_jacobian > 0.258);
            CHECK(figures.smallest_angle > 29.9);
            CHECK(figures.largest_angle < 125.3);
            volume += figures.volume;
        }
        CHECK(volume == 48);
    }
}
