// Outlines of text(): heights, alignment, holes, fonts that are missing.
#include "host/model/outlines/text_outlines.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

using namespace mortise;
using model_reader::Contours;
using model_reader::text_outlines;
using model_reader::TextStyle;
using model_reader::Vec2;

namespace {

struct DrawnText {
    Vec2 min = {1e300, 1e300};
    Vec2 max = {-1e300, -1e300};
    std::vector<Contours> pieces;
    std::vector<std::string> warnings;
};

DrawnText draw(const TextStyle& style) {
    DrawnText drawn;
    drawn.pieces = text_outlines(style, drawn.warnings);
    for (const Contours& piece : drawn.pieces) {
        for (const auto& loop : piece) {
            for (const Vec2& point : loop) {
                for (std::size_t k = 0; k < 2; ++k) {
                    drawn.min[k] = std::min(drawn.min[k], point[k]);
                    drawn.max[k] = std::max(drawn.max[k], point[k]);
                }
            }
        }
    }
    return drawn;
}

TextStyle style_of(const std::string& text, double size = 10) {
    TextStyle style;
    style.text = text;
    style.size = size;
    return style;
}

double covered_area(const Contours& piece) {
    double sum = 0;
    for (const auto& loop : piece) {
        for (std::size_t i = 0; i < loop.size(); ++i) {
            const Vec2& q = loop[(i + 1) % loop.size()];
            sum += loop[i][0] * q[1] - loop[i][1] * q[0];
        }
    }
    return std::fabs(sum) / 2;
}

}  // namespace

TEST_CASE("text: capitals are about as high as the size") {
    // Liberation Sans: capitals 1409 of 2048 units, the em square is size / 0.72.
    for (const double size : {1.0, 10.0, 37.0}) {
        const DrawnText h = draw(style_of("H", size));
        CHECK(h.warnings.empty());
        REQUIRE(h.pieces.size() == 1);
        CHECK(h.pieces[0].size() == 1);
        CHECK(h.pieces[0][0].size() == 12);
        CHECK(h.min[1] == doctest::Approx(0));
        CHECK(h.max[1] == doctest::Approx(size / 0.72 * 1409 / 2048));
        CHECK(h.max[1] == doctest::Approx(size).epsilon(0.06));
    }
}

TEST_CASE("text: holes belong to their letter, accents are pieces of their own") {
    CHECK(draw(style_of("i")).pieces.size() == 2);
    const DrawnText b = draw(style_of("B"));
    REQUIRE(b.pieces.size() == 1);
    CHECK(b.pieces[0].size() == 3);
    CHECK(draw(style_of("Ao8")).pieces.size() == 3);
    CHECK(draw(style_of(" ")).pieces.empty());
    CHECK(draw(style_of("")).pieces.empty());
    // Rounder curves enclose more.
    TextStyle coarse = style_of("o");
    coarse.segments = 1;
    TextStyle fine = coarse;
    fine.segments = 20;
    CHECK(draw(fine).pieces[0][0].size() == 20 * draw(coarse).pieces[0][0].size());
    CHECK(covered_area({draw(fine).pieces[0][0]}) > covered_area({draw(coarse).pieces[0][0]}));
}

TEST_CASE("text: alignment, spacing, direction") {
    TextStyle style = style_of("Hxg");
    const DrawnText left = draw(style);
    style.halign = "right";
    const DrawnText right = draw(style);
    style.halign = "center";
    const DrawnText center = draw(style);
    const double advance = left.min[0] - right.min[0];
    CHECK(advance > left.max[0]);
    CHECK(left.min[0] - center.min[0] == doctest::Approx(advance / 2));
    style = style_of("Hxg");
    style.valign = "top";
    CHECK(draw(style).max[1] == doctest::Approx(0));
    style.valign = "bottom";
    CHECK(draw(style).min[1] == doctest::Approx(0).epsilon(1e-9));
    style.valign = "center";
    CHECK(draw(style).min[1] == doctest::Approx(-draw(style).max[1]));
    style.valign = "baseline";
    CHECK(draw(style).min[1] < -1);  // the g hangs below

    style = style_of("HH");
    style.spacing = 2;
    CHECK(draw(style).max[0] - draw(style_of("HH")).max[0] == doctest::Approx(10 / 0.72 * 1479 / 2048));
    style = style_of("HI");
    style.direction = "ttb";
    CHECK(draw(style).min[1] < -10);
}

TEST_CASE("text: styles, and fonts that are not installed") {
    TextStyle style = style_of("H");
    style.font = "Liberation Sans:style=Bold";
    const DrawnText bold = draw(style);
    CHECK(bold.warnings.empty());
    CHECK(covered_area(bold.pieces[0]) > 1.2 * covered_area(draw(style_of("H")).pieces[0]));
    style.font = "liberation mono";
    CHECK(draw(style).warnings.empty());
    style.font = "No-Such-Font:style=Bold";
    const DrawnText other = draw(style);
    CHECK_FALSE(other.pieces.empty());
    REQUIRE(other.warnings.size() == 1);
    CHECK(other.warnings[0].find("the font 'No-Such-Font' is not installed; '") == 0);
    style = style_of("a\xF0\x9F\x98\x81z");
    const DrawnText missing = draw(style);
    REQUIRE(missing.warnings.size() == 1);
    CHECK(missing.warnings[0].find("lacks 1 of the characters") != std::string::npos);
}

TEST_CASE("text: styles that do not exist") {
    const auto refusal = [](const TextStyle& style) -> std::string {
        try {
            std::vector<std::string> warnings;
            text_outlines(style, warnings);
        } catch (const std::invalid_argument& error) {
            return error.what();
        }
        return {};
    };
    TextStyle style = style_of("H");
    style.halign = "middle";
    CHECK(refusal(style) == "halign is 'middle'; expected left, center or right");
    style = style_of("H");
    style.valign = "middle";
    CHECK(refusal(style) == "valign is 'middle'; expected baseline, bottom, center or top");
    style = style_of("H");
    style.direction = "up";
    CHECK(refusal(style) == "direction is 'up'; expected ltr, rtl, ttb or btt");
    CHECK(refusal(style_of("H", 0)) == "size is not a positive, finite number");
    CHECK(refusal(style_of("H", std::nan(""))) == "size is not a positive, finite number");
    style = style_of("H");
    style.spacing = INFINITY;
    CHECK(refusal(style) == "spacing is not a finite number");
}

TEST_CASE("text: segments per curve") {
    using model_reader::text_segments;
    CHECK(text_segments(10, 0, 12, 2) == 4);  // 30 fragments
    CHECK(text_segments(1, 0, 12, 2) == 2);
    CHECK(text_segments(10, 64, 12, 2) == 9);
    CHECK(text_segments(10, 1e9, 12, 2) == 1251);
}
