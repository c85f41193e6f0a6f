// A cell's tape against all choices of its signs, one by one.
#include <doctest/doctest.h>

#include <algorithm>
#include <set>

#include "host/tape/local_tape.hpp"
#include "host/tape/reference.hpp"
#include "kernels/shared/tape.h"
#include "tests/mesher/random_source.hpp"

namespace mortise::test {
namespace {

constexpr std::size_t kSurfaces = 5;

/// A random formula over kSurfaces surfaces, of one region or two.
std::vector<std::uint32_t> random_tape(RandomSource& random) {
    std::vector<std::uint32_t> tape;
    const auto formula = [&] {
        int depth = 0;
        const int literals = random.integer(1, 6);
        for (int i = 0; i < literals; ++i, ++depth) {
            const auto surface = static_cast<std::uint32_t>(random.integer(0, kSurfaces - 1));
            tape.push_back(make_literal(surface, random.chance(0.5) ? 1 : 0));
        }
        for (; depth > 1; --depth)
            tape.push_back(make_operation(random.chance(0.5) ? kTapeAnd : kTapeOr, 0, 0));
    };
    formula();
    tape.push_back(make_operation(kTapeSelectConst, 2, random.chance(0.5) ? 0 : 1));
    if (random.chance(0.3)) {
        formula();
        tape.push_back(make_operation(kTapeSelect, 3, 0));
    }
    return tape;
}

}  // namespace

TEST_CASE("random tapes: regions and what they depend on, as all choices of the unknown signs tell") {
    RandomSource random(7);
    const std::vector<std::uint32_t> surfaces = {0, 1, 2, 3, 4};
    for (int i = 0; i < 3000; ++i) {
        const std::vector<std::uint32_t> words = random_tape(random);
        tape::LocalTape tape;
        tape.load(words.data(), words.size(), surfaces);
        std::vector<std::int8_t> signs(kSurfaces);
        for (auto& sign : signs) sign = static_cast<std::int8_t>(random.integer(-1, 1));
        std::set<std::int32_t> values;
        bool depends[kSurfaces] = {};
        for (unsigned choice = 0; choice < 1u << kSurfaces; ++choice) {
            std::vector<std::int8_t> trial = signs;
            for (std::size_t s = 0; s < kSurfaces; ++s) {
                if (signs[s] == 0) trial[s] = ((choice >> s) & 1u) != 0 ? 1 : -1;
            }
            const auto value = [&] {
                return tape::evaluate_signs(words.data(), words.size(), surfaces.data(), kSurfaces,
                                            trial.data());
            };
            const std::int32_t here = value();
            values.insert(here);
            for (std::size_t s = 0; s < kSurfaces; ++s) {
                trial[s] = static_cast<std::int8_t>(-trial[s]);
                depends[s] = depends[s] || value() != here;
                trial[s] = static_cast<std::int8_t>(-trial[s]);
            }
        }
        CHECK(tape.resolve(signs.data()) == (values.size() == 1 ? *values.begin() : kUnknown));
        for (std::size_t s = 0; s < kSurfaces; ++s) {
            const bool named = std::any_of(words.begin(), words.end(), [s](std::uint32_t word) {
                return tape_operation(word) == kTapeLiteral && tape_surface(word) == s;
            });
            CHECK(tape.names(s) == named);
            CHECK(tape.depends_on(s, signs.data()) == depends[s]);
        }
    }
}

TEST_CASE("a surface settles what no longer matters on either side of it") {
    // Inside the first surface the second decides, outside it the third.
    const std::uint32_t words[] = {make_literal(0, 0),
                                   make_literal(1, 0),
                                   make_operation(kTapeAnd, 0, 0),
                                   make_literal(0, 1),
                                   make_literal(2, 0),
                                   make_operation(kTapeAnd, 0, 0),
                                   make_operation(kTapeOr, 0, 0),
                                   make_operation(kTapeSelectConst, 1, 0)};
    tape::LocalTape tape;
    tape.load(words, std::size(words), {0, 1, 2});
    const std::uint8_t all[] = {1, 1, 1};
    CHECK(tape.settled_by(0, all) == 2);
    CHECK(tape.settled_by(1, all) == 0);
    CHECK(tape.settled_by(2, all) == 0);
    const std::uint8_t some[] = {1, 0, 1};
    CHECK(tape.settled_by(0, some) == 1);
}

}  // namespace mortise::test
