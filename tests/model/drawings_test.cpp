// DXF, SVG and surface(): areas and places against closed forms; errors.
#include "host/model/outlines/drawings.hpp"
#include "host/common/constants.hpp"

#include <doctest/doctest.h>
#include <png.h>

#include <cmath>
#include <sstream>

#include "host/model/triangles/height_field.hpp"
#include "tests/model/membership.hpp"

using namespace mortise;
using model_reader::Contours;
using model_reader::DrawingOptions;
using model_reader::Vec2;

namespace {

/// A DXF file of entities, given as "code value code value ...".
std::string dxf(const std::string& entities) {
    std::istringstream words("0 SECTION 2 HEADER 9 $ACADVER 1 AC1009 0 ENDSEC 0 SECTION 2 ENTITIES " +
                             entities + " 0 ENDSEC 0 EOF");
    std::string text;
    for (std::string code, value; words >> code >> value;) text += "  " + code + "\r\n" + value + "\r\n";
    return text;
}

struct Drawn {
    std::vector<Contours> pieces;
    std::vector<std::string> warnings;
    std::string error;

    bool holds(double x, double y) const {
        for (const Contours& piece : pieces) {
            bool inside = false;
            for (const auto& loop : piece) {
                for (std::size_t i = 0; i < loop.size(); ++i) {
                    const Vec2& p = loop[i];
                    const Vec2& q = loop[(i + 1) % loop.size()];
                    if ((p[1] > y) == (q[1] > y)) continue;
                    if (x < p[0] + (y - p[1]) / (q[1] - p[1]) * (q[0] - p[0])) inside = !inside;
                }
            }
            if (inside) return true;
        }
        return false;
    }
    /// By counting points of a grid.
    double area(double half = 12, int n = 600) const {
        int count = 0;
        for (int i = 0; i < n; ++i) {
            for (int j = 0; j < n; ++j) {
                count += holds(-half + (2 * i + 0.98) * half / n, -half + (2 * j + 0.97) * half / n);
            }
        }
        return 4 * half * half * count / n / n;
    }
};

Drawn draw(const std::string& content, bool is_svg, DrawingOptions options = {}) {
    if (options.fn == 0) options.fn = 256;
    Drawn drawn;
    try {
        drawn.pieces = is_svg ? model_reader::read_svg(content, "m.svg", options, drawn.warnings)
                              : model_reader::read_dxf(content, "m.dxf", options, drawn.warnings);
    } catch (const Error& error) {
        drawn.error = error.what();
    }
    return drawn;
}

Drawn draw_svg(const std::string& body,
               const std::string& attributes = "width='20mm' height='20mm' viewBox='0 0 20 20'") {
    return draw("<?xml version='1.0'?>\n<svg xmlns='http://www.w3.org/2000/svg' " + attributes + ">\n" +
                    body + "</svg>\n",
                true);
}

std::string line(double x0, double y0, double x1, double y1, const std::string& layer = "0") {
    std::ostringstream text;
    text << " 0 LINE 8 " << layer << " 10 " << x0 << " 20 " << y0 << " 11 " << x1 << " 21 " << y1;
    return text.str();
}

}  // namespace

TEST_CASE("DXF: lines and arcs are joined at their ends, whatever their order and direction") {
    // A slot: two lines and two half circles, with a gap of 0.0005.
    const Drawn slot =
        draw(dxf(line(-2, 1, 2, 1) + line(-2, -1, 2.0005, -1) + " 0 ARC 8 0 10 2 20 0 40 1 50 270 51 90" +
                 " 0 ARC 8 0 10 -2 20 0 40 1 50 90 51 270"),
             false);
    CHECK(slot.error.empty());
    CHECK(slot.warnings.empty());
    REQUIRE(slot.pieces.size() == 1);
    CHECK(slot.pieces[0].size() == 1);
    CHECK(slot.area() == doctest::Approx(8 + kPi).epsilon(0.005));
    CHECK(slot.holds(2.9, 0));
    CHECK_FALSE(slot.holds(2.9, 0.6));
}

TEST_CASE("DXF: polylines with bulges, circles, ellipses") {
    const Drawn both =
        draw(dxf("0 LWPOLYLINE 8 a 90 4 70 1 10 -5 20 -1 42 0 10 5 20 -1 42 1 10 5 20 1 42 0 10 -5 20 1 42 1 "
                 "0 POLYLINE 8 a 66 1 70 1 0 VERTEX 8 a 10 0 20 3 0 VERTEX 8 a 10 2 20 3 42 -0.41421356 "
                 "0 VERTEX 8 a 10 2 20 5 0 VERTEX 8 a 10 0 20 5 0 SEQEND "
                 "0 CIRCLE 8 a 10 0 20 0 40 0.5 0 ELLIPSE 8 a 10 0 20 -5 11 3 21 0 40 0.5"),
             false);
    CHECK(both.error.empty());
    CHECK(both.warnings.empty());
    // A stadium less a circle (even-odd), a square with a dent (a quarter circle's segment), an ellipse.
    const double stadium = 20 + kPi;
    const double segment = 2 * (kPi / 2 - 1) / 2;
    CHECK(both.area() == doctest::Approx(stadium - kPi / 4 + 4 - segment + kPi * 4.5).epsilon(0.003));
    CHECK(both.holds(5.9, 0));
    CHECK_FALSE(both.holds(0, 0));
    CHECK_FALSE(both.holds(1.8, 4));
    // A mirrored coordinate system: x of the file is -x of the drawing.
    const Drawn mirrored = draw(dxf("0 CIRCLE 8 0 10 5 20 0 40 1 230 -1"), false);
    CHECK(mirrored.holds(-5, 0));
}

TEST_CASE("DXF: layer, origin, scale, center") {
    const std::string square =
        line(0, 0, 2, 0, "a") + line(2, 0, 2, 2, "a") + line(2, 2, 0, 2, "a") + line(0, 2, 0, 0, "a");
    const std::string text = dxf(square + " 0 CIRCLE 8 b 10 9 20 9 40 1 0 TEXT 8 b 1 hello");
    DrawingOptions options;
    options.layer = "a";
    options.origin = {1, 1};
    options.scale = 3;
    const Drawn moved = draw(text, false, options);
    CHECK(moved.warnings.empty());
    CHECK(moved.area() == doctest::Approx(36).epsilon(0.01));
    CHECK(moved.holds(-2.9, -2.9));
    options = {};
    options.layer = "b";
    options.center = true;
    const Drawn circle = draw(text, false, options);
    CHECK(circle.holds(0.9, 0));
    CHECK(circle.holds(-0.9, 0));
    REQUIRE(circle.warnings.size() == 1);
    CHECK(circle.warnings[0] == "m.dxf: entities that are no outlines are left out: 1 TEXT");
    options.layer = "c";
    CHECK(draw(text, false, options).error ==
          "m.dxf: there is no closed outline in layer 'c'; expected lines, arcs or polylines that close");
    const Drawn open = draw(dxf(square + line(5, 5, 6, 6) + line(6, 6, 7, 5)), false);
    REQUIRE(open.warnings.size() == 1);
    CHECK(open.warnings[0] == "m.dxf: 1 chain of lines is not closed and left out");
}

TEST_CASE("DXF: errors") {
    const auto error = [](const std::string& content) { return draw(content, false).error; };
    CHECK(error("hello\nworld\n").find("m.dxf:1:1: expected a group code (a whole number), found 'hello'") ==
          0);
    CHECK(error("0\n").find("m.dxf:2:1: expected the value of group 0") == 0);
    CHECK(error("AutoCAD Binary DXF\r\n").find("m.dxf:1:1: binary DXF") == 0);
    CHECK(error("0\nSECTION\n2\nENTITIES\n0\nCIRCLE\n40\nx\n")
              .find("m.dxf:8:1: group 40 of CIRCLE is 'x'; expected a finite number") == 0);
    CHECK(error("0\nSECTION\n2\nENTITIES\n0\nCIRCLE\n40\n-1\n0\nENDSEC\n")
              .find("m.dxf:6:1: CIRCLE: the radius is -1") == 0);
    CHECK(error(dxf("0 SPLINE 8 0")).find(": SPLINE: splines are not read; convert them to polylines") !=
          std::string::npos);
    CHECK(error(dxf("0 INSERT 8 0")).find(": INSERT: inserted blocks are not read") != std::string::npos);
    CHECK(error("0\nSECTION\n2\nENTITIES\n0\nLINE\n").find("inside its ENTITIES section") !=
          std::string::npos);
    CHECK(error("").find("m.dxf: there is no closed outline") == 0);
}

TEST_CASE("SVG: paths with all commands") {
    // A square by each kind of line; y is turned, from the page's lower edge.
    const Drawn lines = draw_svg("<path d='M2,2 L6,2 6,6 H2 Z m10 10h4v4h-4z M 2 12 l4 0 0 4 -4 0z'/>");
    CHECK(lines.error.empty());
    CHECK(lines.area(24) == doctest::Approx(48).epsilon(0.01));
    CHECK(lines.holds(4, 16));
    CHECK(lines.holds(14, 6));
    CHECK(lines.holds(4, 6));
    // Circles of radius 5 about (10, 10): by arcs, by Bézier curves (error 0.03 %), by their smooth forms.
    const double circle = kPi * 25;
    const char* circles[] = {
        "M5,10 A5 5 0 0 1 15 10 A5,5 0 01 5,10 Z",
        "M5,10 a5 5 30 1 0 10 0 a5 5 0 1 0 -10 0",
        "M15 10 C15 12.7614 12.7614 15 10 15 S5 12.7614 5 10 7.2386 5 10 5 15 7.2386 15 10z",
    };
    for (const char* path : circles) {
        CAPTURE(path);
        CHECK(draw_svg("<path d='" + std::string(path) + "'/>").area(24) ==
              doctest::Approx(circle).epsilon(0.003));
    }
    // Parabolas: area two thirds of the box.
    const Drawn parabolas = draw_svg("<path d='M0 10 Q5 0 10 10 T20 10 V20 H0 Z'/>");
    CHECK(parabolas.area(24, 900) == doctest::Approx(200).epsilon(0.005));
    CHECK(parabolas.holds(5, 14.9));
    CHECK_FALSE(parabolas.holds(15, 5.1));
}

TEST_CASE("SVG: shapes, holes, transforms") {
    CHECK(draw_svg("<rect x='1' y='2' width='8' height='4'/>").area(24) == doctest::Approx(32).epsilon(0.01));
    const double corners = 4 - kPi;
    CHECK(draw_svg("<rect x='1' y='2' width='8' height='4' rx='1'/>").area(24) ==
          doctest::Approx(32 - corners).epsilon(0.01));
    CHECK(draw_svg("<circle cx='10' cy='10' r='3'/>").area(24) == doctest::Approx(kPi * 9).epsilon(0.01));
    CHECK(draw_svg("<ellipse cx='10' cy='10' rx='3' ry='6'/>").area(24) ==
          doctest::Approx(kPi * 18).epsilon(0.01));
    CHECK(draw_svg("<polygon points='0,0 10,0 10,10'/>").area(24) == doctest::Approx(50).epsilon(0.01));
    // By winding a loop inside another is a hole only if it turns the other way.
    const std::string outer = "M0 0 H10 V10 H0 Z";
    CHECK(draw_svg("<path d='" + outer + " M2 2 V8 H8 V2 Z'/>").area(24) ==
          doctest::Approx(64).epsilon(0.01));
    CHECK(draw_svg("<path d='" + outer + " M2 2 H8 V8 H2 Z'/>").area(24) ==
          doctest::Approx(100).epsilon(0.01));
    CHECK(draw_svg("<g style='fill: red; fill-rule: evenodd'><path d='" + outer + " M2 2 H8 V8 H2 Z'/></g>")
              .area(24) == doctest::Approx(64).epsilon(0.01));
    // Overlapping shapes are united.
    CHECK(draw_svg("<rect width='4' height='4'/><rect x='2' width='4' height='4'/>").area(24) ==
          doctest::Approx(24).epsilon(0.01));
    const Drawn turned = draw_svg(
        "<g transform='translate(10 10) rotate(90)'><g transform='scale(2)'><rect x='1' y='0' width='2' "
        "height='1'/></g></g>");
    // x 2..6, y 0..2, turned clockwise on the page: x -2..0, y 2..6, about (10, 10), then y upwards.
    CHECK(turned.holds(9, 6));
    CHECK(turned.area(24) == doctest::Approx(8).epsilon(0.01));
    CHECK(
        draw_svg("<rect transform='matrix(1 0 0 1 5 5) skewX(45)' width='2' height='2'/>").holds(8.5, 13.2));
    CHECK(draw_svg("<rect transform='rotate(180, 5, 5)' width='2' height='2'/>").holds(9, 11));
}

TEST_CASE("SVG: units, pages, layers, what is left out") {
    const std::string body = "<rect width='72' height='72'/>";
    CHECK(draw_svg(body, "width='72' height='72'").area(30) == doctest::Approx(25.4 * 25.4).epsilon(0.01));
    CHECK(draw_svg(body, "").holds(20, -20));  // no page: y is only turned
    CHECK(draw_svg(body, "viewBox='0 0 72 72'").area(30) == doctest::Approx(25.4 * 25.4).epsilon(0.01));
    CHECK(draw_svg(body, "viewBox='0 0 72 72' width='1cm' height='1cm'").area(30) ==
          doctest::Approx(100).epsilon(0.02));
    CHECK(draw_svg(body, "viewBox='0 0 72 72' width='100%' height='100%'").area(30) ==
          doctest::Approx(25.4 * 25.4).epsilon(0.01));
    CHECK(draw_svg(body, "viewBox='0 0 72 72' width='2cm' height='1cm'").holds(14, 5));
    CHECK_FALSE(draw_svg(body, "viewBox='0 0 72 72' width='2cm' height='1cm'").holds(16, 5));
    CHECK(draw_svg("<rect width='1in' height='36pt'/>", "").area(30) ==
          doctest::Approx(25.4 * 12.7).epsilon(0.01));
    DrawingOptions options;
    options.dpi = 96;
    options.center = true;
    const Drawn fine = draw("<svg><rect width='96' height='96'/></svg>", true, options);
    CHECK(fine.area(30) == doctest::Approx(25.4 * 25.4).epsilon(0.01));
    CHECK(fine.holds(12, 12));
    options = {};
    options.layer = "b";
    const Drawn layer = draw(
        "<svg><g id='a'><rect width='50' height='50'/></g><g id='b'><rect width='10' height='10'/></g></svg>",
        true, options);
    CHECK(layer.area() == doctest::Approx(12.446).epsilon(0.02));

    const Drawn partly = draw_svg(
        "<defs><rect width='9' height='9'/></defs><text>a</text><rect display='none' width='5' height='5'/>"
        "<rect width='2' height='2'/><path fill='none' d='M5 5 L9 5 9 9'/><metadata/>");
    CHECK(partly.area() == doctest::Approx(0));
    CHECK(partly.area(24) == doctest::Approx(4).epsilon(0.03));
    REQUIRE(partly.warnings.size() == 2);
    CHECK(partly.warnings[0] == "m.svg: 1 line that is neither closed nor filled left out");
    CHECK(partly.warnings[1] == "m.svg: elements that are no outlines are left out: 1 <text>");
}

TEST_CASE("messages about drawings show what they found in one short line") {
    const std::string zeros = "0\nSECTION\n2\nENTITIES\n0\nCIRCLE\n40\n1" + std::string(2, '\0') + "2\n";
    CHECK(draw(zeros, false).error == "m.dxf:8:1: group 40 of CIRCLE is '1  2'; expected a finite number");
    const std::string long_number(300, '9');
    CHECK(draw_svg("<circle r='x" + long_number + "'/>").error ==
          "m.svg:3:2: r is 'x" + long_number.substr(0, 39) + "...'; expected a length such as 12 or 3.5mm");
}

TEST_CASE("SVG: errors") {
    const auto error = [](const std::string& body) { return draw_svg(body).error; };
    CHECK(error("<rect").find("m.svg:") == 0);
    CHECK(error("<rect").find("not well-formed XML") != std::string::npos);
    CHECK(error("<path d='M0 0 L5 x'/>")
              .find("m.svg:3:2: <path>: expected a number, found 'x' in 'M0 0 L5 x'") == 0);
    CHECK(error("<path d='L5 5'/>").find("<path>: expected the command M first") != std::string::npos);
    CHECK(error("<path d='M0 0 B5'/>").find("expected a path command, found 'B5'") != std::string::npos);
    CHECK(error("<path d='M0 0 z 5 5'/>").find("expected a path command, found '5 5'") != std::string::npos);
    CHECK(error("<path d='M0 0 A5 5 0 2 0 1 1'/>").find("expected 0 or 1") != std::string::npos);
    CHECK(error("<polygon points='0 0 1 1 2'/>").find("the last one lacks its y") != std::string::npos);
    CHECK(error("<g transform='turn(3)'/>").find("the transform 'turn' with 1 numbers is not known") !=
          std::string::npos);
    CHECK(error("<rect width='2em' height='1'/>").find("width is '2em'; expected px, mm") !=
          std::string::npos);
    CHECK(error("").find("m.svg: there is no closed shape") == 0);
    CHECK(draw("<html></html>", true).error.find("m.svg:1:2: expected an <svg> document, found <html>") == 0);
}

TEST_CASE("surface: heights from text") {
    std::vector<std::string> warnings;
    const std::string text = "# heights\n1 2 3\n1 2 3\n\n 1 2 3.0\n 1 2 4e0 \n";
    Model model;
    const std::uint32_t node =
        model.add_primitive(polyhedron(model_reader::read_height_surface(text, "m.dat", false, false)));
    // Base 0; three rows of unit squares, the last with a corner at 4.
    CHECK(test::holds(model, node, {0.5, 0.3, 1.4}));
    CHECK_FALSE(test::holds(model, node, {0.5, 0.3, 1.6}));
    CHECK(test::holds(model, node, {1.95, 2.95, 3.8}));
    CHECK_FALSE(test::holds(model, node, {1.95, 1.95, 3.8}));
    CHECK(test::holds(model, node, {1, 1.5, 0.05}));
    CHECK_FALSE(test::holds(model, node, {1, 1.5, -0.05}));
    CHECK_FALSE(test::holds(model, node, {2.05, 1.5, 1}));
    const std::uint32_t centered = model.add_primitive(
        polyhedron(model_reader::read_height_surface("0 0\n0 -3\n", "m.dat", true, false)));
    CHECK(test::holds(model, centered, {-0.4, -0.4, -3.9}));
    CHECK_FALSE(test::holds(model, centered, {-0.4, -0.4, -4.1}));
    CHECK_FALSE(test::holds(model, centered, {0.4, 0.4, -1}));

    const auto error = [](const std::string& content) -> std::string {
        try {
            model_reader::read_height_surface(content, "m.dat", false, false);
        } catch (const Error& e) {
            return e.what();
        }
        return {};
    };
    CHECK(error("1 2\n3\n") == "m.dat:2:1: this row has 1 heights; expected 2 as in the first row");
    CHECK(error("1 2\n3 x\n").find("m.dat:2:3: expected a coordinate") == 0);
    CHECK(error("1 2\n") == "m.dat: 1 rows of 2 heights; expected at least two rows and two columns");
    CHECK(error("") == "m.dat: 0 rows of 0 heights; expected at least two rows and two columns");
    CHECK(error("\x89PNG\r\n").find("m.dat: the PNG picture cannot be read: ") == 0);
}

TEST_CASE("surface: heights from a picture") {
    // White above, black below.
    png_image image{};
    image.version = PNG_IMAGE_VERSION;
    image.width = 3;
    image.height = 2;
    image.format = PNG_FORMAT_GRAY;
    const png_byte pixels[6] = {255, 255, 255, 0, 0, 0};
    png_alloc_size_t size = 0;
    REQUIRE(png_image_write_to_memory(&image, nullptr, &size, 0, pixels, 0, nullptr) != 0);
    std::string content(size, '\0');
    REQUIRE(png_image_write_to_memory(&image, content.data(), &size, 0, pixels, 0, nullptr) != 0);
    Model model;
    const std::uint32_t plain =
        model.add_primitive(polyhedron(model_reader::read_height_surface(content, "m.png", false, false)));
    CHECK(test::holds(model, plain, {1, 0.99, 97}));
    CHECK_FALSE(test::holds(model, plain, {1, 0.01, 2}));
    CHECK(test::holds(model, plain, {1, 0.01, -0.9}));
    const std::uint32_t inverted =
        model.add_primitive(polyhedron(model_reader::read_height_surface(content, "m.png", false, true)));
    CHECK(test::holds(model, inverted, {1, 0.01, 97}));
    CHECK_FALSE(test::holds(model, inverted, {1, 0.99, 2}));
}

TEST_CASE("SVG: groups nested very deeply") {
    constexpr int kDeep = 20000;
    std::string body;
    for (int i = 0; i < kDeep; ++i) body += "<g>";
    body += "<rect width='4' height='4'/>";
    for (int i = 0; i < kDeep; ++i) body += "</g>";
    CHECK(draw_svg(body).area(24) == doctest::Approx(16).epsilon(0.02));
}

TEST_CASE("numbers of drawings that are far too large or too small") {
    // An arc's radii are enlarged until it reaches its end: tiny ones make a half circle over the chord.
    const Drawn tiny = draw_svg("<path d='M5 10 A1e-300 1e-300 0 0 1 15 10 Z'/>");
    CHECK(tiny.error.empty());
    CHECK(tiny.area(24) == doctest::Approx(kPi * 25 / 2).epsilon(0.01));
    // Angles of many turns; what is left of 1e300 degrees is some angle, but one of less than a turn.
    CHECK(draw(dxf("0 ARC 8 0 10 0 20 0 40 1 50 0 51 1e300" + line(0, 0, 1, 0)), false)
              .error.find("m.dxf: there is no") == 0);
    CHECK(draw(dxf("0 ARC 8 0 10 0 20 0 40 1 50 -720 51 900" + line(-1, 0, 1, 0)), false).area(4) ==
          doctest::Approx(kPi / 2).epsilon(0.02));
    const Drawn some = draw(dxf("0 ELLIPSE 8 0 10 0 20 0 11 1 21 0 40 1 41 -1e300 42 1e300"), false);
    CHECK(some.error.find("m.dxf: there is no closed outline") == 0);
    CHECK(draw(dxf("0 LWPOLYLINE 8 0 70 1e300"), false)
              .error.find("group 70 of LWPOLYLINE is 1e+300; expected a whole") != std::string::npos);
    // Bulges next to nothing have circles beyond all numbers.
    CHECK(
        draw(dxf("0 LWPOLYLINE 8 0 70 1 10 0 20 0 42 1e-320 10 2 20 0 42 0 10 2 20 2 42 0"), false).area(4) ==
        doctest::Approx(2).epsilon(0.02));
}
