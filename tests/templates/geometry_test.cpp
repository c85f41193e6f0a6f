// The committed template table, geometrically: volumes, positive Jacobians, quality as documented.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <sstream>
#include <string>

#include "host/templates/measure.hpp"
#include "host/templates/search.hpp"
#include "tests/templates/table_access.hpp"

using namespace mortise::templates;
using namespace template_tests;

namespace {

Template row_of(int pattern) {
    return {elements_of(pattern), kTemplateRows[pattern].interior_mean, surface_of(pattern), {}};
}

void place_interior(int pattern, Positions& positions) {
    const NodeSet nodes = kTemplateRows[pattern].interior_mean;
    if (nodes != 0) positions[kTemplateInteriorCode] = mean(positions, nodes);
}

double element_volume(int pattern, const Positions& positions) {
    double volume = 0;
    for (const Element& element : elements_of(pattern)) {
        volume += enclosed_volume(element_facets(element), positions);
    }
    return volume;
}

/// Volume of the unit cube below a plane, by inclusion and exclusion over the corners. Flipping axes makes
/// every component of the normal positive; precondition: none is near 0.
double volume_below(const Plane& plane) {
    std::array<double, 3> n = plane.normal;
    double offset = plane.offset;
    for (double& x : n) {
        if (x < 0) {
            offset -= x;
            x = -x;
        }
    }
    double sum = 0;
    for (int c = 0; c < kCorners; ++c) {
        const double below = offset - (c & 1) * n[0] - (c >> 1 & 1) * n[1] - (c >> 2 & 1) * n[2];
        if (below > 0) sum += (bits(static_cast<std::uint32_t>(c)) % 2 == 0 ? 1 : -1) * below * below * below;
    }
    return sum / (6 * n[0] * n[1] * n[2]);
}

bool all_positive(int pattern, const Positions& positions) {
    const auto elements = elements_of(pattern);
    return std::all_of(elements.begin(), elements.end(), [&](const Element& element) {
        return scaled_jacobian(element, positions) > 0 && is_positive(element, positions);
    });
}

/// Share of independent cuts in [low, high] for which every element is positive.
double positive_share(int pattern, double low, double high, int count) {
    Random random(31);
    int positive = 0;
    for (int i = 0; i < count; ++i) {
        Positions positions = independent_positions(static_cast<Pattern>(pattern), low, high, random);
        place_interior(pattern, positions);
        if (all_positive(pattern, positions)) ++positive;
    }
    return static_cast<double>(positive) / count;
}

}  // namespace

TEST_CASE("positive everywhere: a cube yes, inverted no, twisted with good corners no") {
    Random random(1);
    Positions cube = independent_positions(255, 0, 1, random);
    const Element upright = {ElementType::kHexahedron, {0, 1, 3, 2, 4, 5, 7, 6}};
    const Element inverted = {ElementType::kHexahedron, {4, 5, 7, 6, 0, 1, 3, 2}};
    CHECK(is_positive(upright, cube));
    CHECK(scaled_jacobian(upright, cube) == doctest::Approx(1));
    CHECK(dihedral_cosines(upright, cube).largest == doctest::Approx(0));
    CHECK_FALSE(is_positive(inverted, cube));
    // The top turned by a half turn less a little: positive at the corners, negative in the middle.
    const double angle = 0.99 * 3.14159265358979323846 / 2;
    Positions twisted = cube;
    for (std::size_t c = 4; c < 8; ++c) {
        const double x = cube[c][0] - 0.5, y = cube[c][1] - 0.5;
        twisted[c][0] = 0.5 + std::cos(2 * angle) * x - std::sin(2 * angle) * y;
        twisted[c][1] = 0.5 + std::sin(2 * angle) * x + std::cos(2 * angle) * y;
    }
    CHECK_FALSE(is_positive(upright, twisted));
}

TEST_CASE("every element is positive and volumes add up, for exact plane cuts") {
    Random random(11);
    for (int p = 1; p < 255; ++p) {
        const auto pattern = static_cast<Pattern>(p);
        if (!has_template(p) || !is_separable(pattern)) continue;
        CAPTURE(p);
        int failures = 0;
        double worst_volume = 0;
        for (int i = 0; i < 400; ++i) {
            const Plane plane = i % 4 == 0 ? extreme_plane(pattern, random) : random_plane(pattern, random);
            // Nearer to the ends a cut is not usable as a node; the clipped cuts are checked below.
            Positions exact = plane_positions(pattern, plane, 0);
            Positions clipped = plane_positions(pattern, plane, kCutMargin);
            place_interior(p, exact);
            place_interior(p, clipped);
            const bool usable = exact == clipped;
            if (usable && !all_positive(p, exact)) ++failures;
            if (!all_positive(p, clipped)) ++failures;
            const auto& n = plane.normal;
            if (std::min({std::abs(n[0]), std::abs(n[1]), std::abs(n[2])}) < 0.01) continue;
            worst_volume = std::max(worst_volume, std::abs(element_volume(p, exact) - volume_below(plane)));
        }
        CHECK(failures == 0);
        CHECK(worst_volume < 1e-9);  // the closed form divides by n0 n1 n2 >= 1e-4 / 2
    }
}

TEST_CASE("volumes add up to the face meshes' and the surface's, for independent cuts") {
    Random random(12);
    for (int p = 1; p < 255; ++p) {
        if (!has_template(p)) continue;
        CAPTURE(p);
        std::vector<Facet> boundary = surface_of(p);
        for (int f = 0; f < kFaces; ++f) {
            for (const Facet& facet : face_facets(p, f)) boundary.push_back(facet);
        }
        double worst = 0;
        double worst_pair = 0;
        for (int i = 0; i < 50; ++i) {
            Positions positions = independent_positions(static_cast<Pattern>(p), 0.01, 0.99, random);
            place_interior(p, positions);
            const double volume = element_volume(p, positions);
            worst = std::max(worst, std::abs(volume - enclosed_volume(boundary, positions)));
            // The complement's template fills the rest of the cell.
            Positions other = positions;
            place_interior(255 - p, other);
            worst_pair = std::max(worst_pair, std::abs(volume + element_volume(255 - p, other) - 1));
        }
        CHECK(worst < 1e-12);
        CHECK(worst_pair < 1e-12);
    }
}

TEST_CASE("independent cuts: share of cells with every element positive") {
    // Curved surfaces cut edges independently of each other. Shares of 1 are relied on for cuts in [0.2,
    // 0.8].
    std::array<bool, 10> seen{};
    for (int p = 1; p < 255; ++p) {
        if (!has_template(p)) continue;
        const std::size_t shape = kTemplateRows[p].shape;
        CAPTURE(p);
        CAPTURE(shape);
        const double middle = positive_share(p, 0.2, 0.8, 300);
        CHECK(middle == 1);
        if (seen[shape]) continue;
        seen[shape] = true;
        MESSAGE("shape ", shape, ": ", middle, " for cuts in [0.2, 0.8], ",
                positive_share(p, 0.05, 0.95, 3000), " in [0.05, 0.95]");
    }
}

TEST_CASE("quality on fresh samples is as documented in the table") {
    std::ifstream file(MORTISE_TEMPLATE_TABLE, std::ios::binary);
    std::string line;
    int rows = 0;
    while (std::getline(file, line) && line.rfind("#ifndef", 0) != 0) {
        // "//   SHAPE NAME PATTERN H W P T NODE POSITIVE FREE SJ SJ_LOW SMALLEST LOW LARGEST"
        std::istringstream words(line);
        std::vector<std::string> word;
        for (std::string w; words >> w;) word.push_back(w);
        if (word.size() < 15 || word[1].size() != 1 || word[1][0] < '1' || word[1][0] > '9') continue;
        ++rows;
        const auto number = [&](std::size_t from_end) { return std::stod(word[word.size() - from_end]); };
        const int p = static_cast<int>(number(13));
        const int count = 4000;
        const Score score = measure(row_of(p), measured_positions(static_cast<Pattern>(p), 424242, count));
        MESSAGE("shape ", word[1], " pattern ", p, ": dihedral ", score.smallest_dihedral, " to ",
                score.largest_dihedral, ", scaled Jacobian ", score.worst_jacobian, ", 1 % ",
                score.low_jacobian);
        CHECK(kTemplateRows[p].shape == word[1][0] - '0');
        CHECK(score.positive == doctest::Approx(number(7)));
        CHECK(score.worst_jacobian > number(5) / 4);
        CHECK(score.low_jacobian > number(4) / 2);
        CHECK(score.low_jacobian < number(4) * 2);
        CHECK(score.low_angle > number(2) / 2);
        CHECK(score.low_angle < number(2) * 2);
        CHECK(score.largest_dihedral < number(1) + 2);
    }
    CHECK(rows == 12);
}
