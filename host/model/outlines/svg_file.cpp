// SVG: walks the document and maps its shapes to millimetres, y upwards from the page's lower edge.
#include <algorithm>
#include <cmath>
#include <map>
#include <pugixml.hpp>
#include <stdexcept>

#include "host/common/message_text.hpp"
#include "host/model/outlines/drawings.hpp"
#include "host/model/outlines/outline_pieces.hpp"
#include "host/model/outlines/svg_path.hpp"
#include "host/model/text.hpp"

namespace mortise::model_reader {
namespace {

constexpr double kInch = 25.4;

SourceLocation place_of(const std::string& content, std::ptrdiff_t offset) {
    SourceLocation where{1, 1};
    for (std::ptrdiff_t i = 0; i < offset && static_cast<std::size_t>(i) < content.size(); ++i) {
        ++where.column;
        if (content[static_cast<std::size_t>(i)] != '\n') continue;
        ++where.line;
        where.column = 1;
    }
    return where;
}

/// A property, given as attribute or in `style`.
std::string property(const pugi::xml_node& node, const std::string& name) {
    const std::string style = node.attribute("style").value();
    for (std::size_t at = 0; at < style.size();) {
        std::size_t end = style.find(';', at);
        if (end == std::string::npos) end = style.size();
        const std::size_t colon = style.find(':', at);
        if (colon < end) {
            const auto trimmed = [&](std::size_t from, std::size_t to) {
                while (from < to && style[from] == ' ') ++from;
                while (to > from && style[to - 1] == ' ') --to;
                return style.substr(from, to - from);
            };
            if (trimmed(at, colon) == name) return trimmed(colon + 1, end);
        }
        at = end + 1;
    }
    return node.attribute(name.c_str()).value();
}

class SvgReader {
  public:
    SvgReader(const std::string& content, const std::string& source, const DrawingOptions& options)
        : content_(content), source_(source), options_(options) {}

    std::vector<Contours> read(std::vector<std::string>& warnings) {
        pugi::xml_document document;
        const pugi::xml_parse_result result = document.load_buffer(content_.data(), content_.size());
        if (!result) {
            fail(source_, place_of(content_, result.offset),
                 std::string("not well-formed XML: ") + result.description());
        }
        const pugi::xml_node svg = document.document_element();
        if (name_of(svg) != "svg") {
            fail_at(svg, "expected an <svg> document, found <" + std::string(svg.name()) + ">");
        }
        walk(svg, page_map(svg));
        if (pieces_.empty()) {
            const std::string where = options_.layer.empty() ? "" : " in '" + options_.layer + "'";
            throw Error(ExitCode::kInput, source_ + ": there is no closed shape" + where +
                                              "; expected paths, rectangles, circles or polygons");
        }
        if (open_ != 0) {
            warnings.push_back(source_ + ": " + counted(open_, "line that is", "lines that are") +
                               " neither closed nor filled left out");
        }
        if (!ignored_.empty()) {
            std::string list;
            for (const auto& [name, count] : ignored_) {
                list += (list.empty() ? "" : ", ") + std::to_string(count) + " <" + name + ">";
            }
            warnings.push_back(source_ + ": elements that are no outlines are left out: " + list);
        }
        if (options_.center) center_pieces(pieces_);
        return std::move(pieces_);
    }

  private:
    /// Without a namespace's prefix.
    static std::string name_of(const pugi::xml_node& node) {
        const std::string name = node.name();
        const std::size_t colon = name.find(':');
        return colon == std::string::npos ? name : name.substr(colon + 1);
    }

    [[noreturn]] void fail_at(const pugi::xml_node& node, const std::string& message) const {
        fail(source_, place_of(content_, node.offset_debug()), message);
    }

    /// A length in millimetres, or user units where `in_user_units`; `otherwise` for a missing one or a
    /// percentage.
    double length_of(const pugi::xml_node& node, const char* name, double otherwise,
                     bool in_user_units) const {
        const std::string text = node.attribute(name).value();
        if (text.empty()) return otherwise;
        std::size_t end = text.find_last_of("0123456789.");
        if (end == std::string::npos) end = 0;
        const std::string unit = text.substr(std::min(end + 1, text.size()));
        double value = 0;
        try {
            const std::vector<double> numbers = svg_numbers(text.substr(0, end + 1));
            if (numbers.size() != 1) throw std::invalid_argument("one number");
            value = numbers[0];
        } catch (const std::invalid_argument&) {
            fail_at(node,
                    std::string(name) + " is '" + excerpt(text) + "'; expected a length such as 12 or 3.5mm");
        }
        if (unit == "%") return otherwise;
        const double pixel = kInch / options_.dpi;
        static const std::map<std::string, double> kUnits = {
            {"mm", 1}, {"cm", 10}, {"in", kInch}, {"pt", kInch / 72}, {"pc", kInch / 6}};
        double millimetres = value * pixel;
        const auto known = kUnits.find(unit);
        if (known != kUnits.end()) {
            millimetres = value * known->second;
        } else if (!unit.empty() && unit != "px") {
            fail_at(node,
                    std::string(name) + " is '" + excerpt(text) + "'; expected px, mm, cm, in, pt or pc");
        }
        return in_user_units ? millimetres / pixel : millimetres;
    }

    /// User units of the outermost element to millimetres.
    SvgMap page_map(const pugi::xml_node& svg) {
        const double pixel = kInch / options_.dpi;
        std::vector<double> box;
        try {
            box = svg_numbers(svg.attribute("viewBox").value());
        } catch (const std::invalid_argument& error) {
            fail_at(svg, std::string("viewBox: ") + error.what());
        }
        double width = length_of(svg, "width", 0, false);
        double height = length_of(svg, "height", 0, false);
        const bool has_box = box.size() == 4 && box[2] > 0 && box[3] > 0;
        if (!has_box) return {pixel, 0, 0, -pixel, 0, height};
        if (!(width > 0)) width = height > 0 ? height * box[2] / box[3] : box[2] * pixel;
        if (!(height > 0)) height = width * box[3] / box[2];
        double x = width / box[2];
        double y = height / box[3];
        if (std::string(svg.attribute("preserveAspectRatio").value()).compare(0, 4, "none") != 0)
            x = y = std::min(x, y);
        // The box in the middle of the page.
        const double left = (width - x * box[2]) / 2;
        const double top = (height - y * box[3]) / 2;
        return {x, 0, 0, -y, left - x * box[0], height - top + y * box[1]};
    }

    /// Inherited properties that decide which areas are filled.
    struct Paint {
        bool filled = true;
        bool even_odd = false;

        Paint inside(const pugi::xml_node& node) const {
            Paint result = *this;
            const std::string fill = property(node, "fill");
            const std::string rule = property(node, "fill-rule");
            if (!fill.empty() && fill != "inherit") result.filled = fill != "none";
            if (!rule.empty() && rule != "inherit") result.even_odd = rule == "evenodd";
            return result;
        }
    };

    void walk(const pugi::xml_node& root, const SvgMap& page) {
        struct Pending {
            pugi::xml_node node;
            SvgMap map;
            bool selected;  ///< inside the layer that is wanted
            Paint paint;
        };
        std::vector<Pending> pending = {{root, page, options_.layer.empty(), {}}};
        while (!pending.empty()) {
            auto [node, map, selected, outer] = pending.back();
            pending.pop_back();
            const Paint paint = outer.inside(node);
            const std::string name = name_of(node);
            if (property(node, "display") == "none") continue;
            try {
                if (node != root) map = svg_compose(map, svg_transform(node.attribute("transform").value()));
                selected = selected || options_.layer == node.attribute("id").value() ||
                           options_.layer == node.attribute("inkscape:label").value();
                if (name == "g" || name == "a" || name == "switch" || name == "svg") {
                    if (name == "svg" && node != root) {
                        map = svg_compose(
                            map, {1, 0, 0, 1, length_of(node, "x", 0, true), length_of(node, "y", 0, true)});
                    }
                    for (pugi::xml_node child = node.last_child(); child; child = child.previous_sibling()) {
                        if (child.type() == pugi::node_element)
                            pending.push_back({child, map, selected, paint});
                    }
                } else if (selected) {
                    add_shape(node, name, map, paint);
                }
            } catch (const std::invalid_argument& error) {
                fail_at(node, "<" + std::string(node.name()) + ">: " + error.what());
            }
        }
    }

    void add_shape(const pugi::xml_node& node, const std::string& name, const SvgMap& map,
                   const Paint& paint) {
        const SvgFineness fineness = {options_, std::sqrt(std::fabs(map[0] * map[3] - map[1] * map[2]))};
        const auto length = [&](const char* attribute) { return length_of(node, attribute, 0, true); };
        SvgOutline outline;
        if (name == "path") {
            outline = svg_path(node.attribute("d").value(), fineness);
        } else if (name == "rect") {
            const double width = length("width");
            const double height = length("height");
            double rx = length_of(node, "rx", -1, true);
            double ry = length_of(node, "ry", -1, true);
            if (rx < 0) rx = std::max(ry, 0.0);
            if (ry < 0) ry = rx;
            if (width > 0 && height > 0) {
                outline = svg_rectangle(length("x"), length("y"), width, height, rx, ry, fineness);
            }
        } else if (name == "circle" || name == "ellipse") {
            const double rx = length(name == "circle" ? "r" : "rx");
            const double ry = length(name == "circle" ? "r" : "ry");
            if (rx > 0 && ry > 0) outline = svg_ellipse(length("cx"), length("cy"), rx, ry, fineness);
        } else if (name == "polygon" || name == "polyline") {
            const std::vector<double> numbers = svg_numbers(node.attribute("points").value());
            if (numbers.size() % 2 != 0) throw std::invalid_argument("points: the last one lacks its y");
            if (numbers.size() >= 6) {
                outline.loops.emplace_back();
                outline.open = {static_cast<char>(name == "polyline" ? 1 : 0)};
                for (std::size_t i = 0; i < numbers.size(); i += 2) {
                    outline.loops[0].push_back({numbers[i], numbers[i + 1]});
                }
            }
        } else {
            if (name == "text" || name == "use" || name == "image" || name == "line") ++ignored_[name];
            return;
        }
        Contours loops;
        for (std::size_t i = 0; i < outline.loops.size(); ++i) {
            // Filling closes what is open; a mere line is no area.
            if (!paint.filled && outline.open[i] != 0) {
                ++open_;
                continue;
            }
            for (Vec2& p : outline.loops[i]) {
                p = {map[0] * p[0] + map[2] * p[1] + map[4], map[1] * p[0] + map[3] * p[1] + map[5]};
            }
            loops.push_back(std::move(outline.loops[i]));
        }
        if (loops.empty()) return;
        if (paint.even_odd) {
            pieces_.push_back(std::move(loops));
        } else {
            add_winding_pieces(std::move(loops), pieces_);
        }
    }

    const std::string& content_;
    const std::string& source_;
    const DrawingOptions& options_;
    std::vector<Contours> pieces_;
    std::map<std::string, int> ignored_;
    std::size_t open_ = 0;
};

}  // namespace

std::vector<Contours> read_svg(const std::string& content, const std::string& source,
                               const DrawingOptions& options, std::vector<std::string>& warnings) {
    return SvgReader(content, source, options).read(warnings);
}

}  // namespace mortise::model_reader
