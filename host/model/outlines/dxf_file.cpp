// DXF (AutoCAD's drawing exchange format, text): pairs of lines, a group code and a value. Read are the
// entities LINE, LWPOLYLINE, POLYLINE, ARC, CIRCLE and ELLIPSE; ends closer than 0.001 are joined.
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <map>
#include <numeric>
#include <string_view>

#include "host/common/constants.hpp"
#include "host/common/message_text.hpp"
#include "host/model/outlines/drawings.hpp"
#include "host/model/outlines/outline_pieces.hpp"
#include "host/model/text.hpp"

namespace mortise::model_reader {
namespace {

/// Ends of lines closer than this are one point, in units of the drawing as in OpenSCAD.
constexpr double kJoin = 1e-3;
/// Bulges below this are lines; the circle of a still smaller one would be beyond all numbers.
constexpr double kStraightBulge = 1e-12;

struct Group {
    int code = 0;
    std::string_view value;
    SourceLocation where;
};

class GroupReader {
  public:
    GroupReader(const std::string& content, const std::string& source) : cursor_(content, source) {}

    /// False at the end of the file.
    bool next(Group& group) {
        cursor_.skip_blanks();
        if (cursor_.at_end()) return false;
        const TextCursor start = cursor_;
        const std::string_view line = trimmed(cursor_.take_line());
        const auto result = std::from_chars(line.data(), line.data() + line.size(), group.code);
        if (result.ec != std::errc() || result.ptr != line.data() + line.size()) {
            start.fail_here("expected a group code (a whole number), found " + start.found() +
                            "; is this a DXF file in text form?");
        }
        end_line();
        if (cursor_.at_end()) cursor_.fail_here("expected the value of group " + std::to_string(group.code));
        while (cursor_.peek() == ' ' || cursor_.peek() == '\t') cursor_.advance();
        group.where = cursor_.where();
        group.value = trimmed(cursor_.take_line());
        end_line();
        return true;
    }

  private:
    static std::string_view trimmed(std::string_view text) {
        while (!text.empty() && (text.back() == ' ' || text.back() == '\t')) text.remove_suffix(1);
        return text;
    }
    void end_line() {
        if (cursor_.peek() == '\r') cursor_.advance();
        if (cursor_.peek() == '\n') cursor_.advance();
    }
    TextCursor cursor_;
};

/// An entity's groups that matter here.
struct Entity {
    std::string_view type;
    SourceLocation where;
    std::string_view layer;
    std::map<int, double> numbers;  ///< the last of each code
    struct Vertex {
        Vec2 point{};
        double bulge = 0;  ///< tangent of a quarter of the arc's angle to the next vertex
    };
    std::vector<Vertex> vertices;

    double number(int code, double otherwise = 0) const {
        const auto found = numbers.find(code);
        return found == numbers.end() ? otherwise : found->second;
    }
};

class DxfReader {
  public:
    DxfReader(const std::string& content, const std::string& source, const DrawingOptions& options)
        : groups_(content, source), source_(source), options_(options) {}

    std::vector<Contours> read(std::vector<std::string>& warnings) {
        read_entities();
        join();
        if (loops_.empty()) {
            const std::string where = options_.layer.empty() ? "" : " in layer '" + options_.layer + "'";
            throw Error(ExitCode::kInput, source_ + ": there is no closed outline" + where +
                                              "; expected lines, arcs or polylines that close");
        }
        if (open_ != 0) {
            warnings.push_back(source_ + ": " + counted(open_, "chain of lines is", "chains of lines are") +
                               " not closed and left out");
        }
        if (!ignored_.empty()) {
            std::string list;
            for (const auto& [type, count] : ignored_) {
                list += (list.empty() ? "" : ", ") + std::to_string(count) + " " + type;
            }
            warnings.push_back(source_ + ": entities that are no outlines are left out: " + list);
        }
        for (auto& loop : loops_) {
            for (Vec2& point : loop) {
                for (std::size_t k = 0; k < 2; ++k) {
                    point[k] = (point[k] - options_.origin[k]) * options_.scale;
                }
            }
        }
        std::vector<Contours> pieces = {std::move(loops_)};
        if (options_.center) center_pieces(pieces);
        return pieces;
    }

  private:
    void read_entities() {
        Group group;
        Entity entity;
        bool in_entities = false;
        bool after_section = false;
        bool in_polyline = false;
        Entity polyline;
        const auto finish = [&] {
            if (entity.type.empty()) return;
            if (entity.type == "POLYLINE") {
                polyline = entity;
                polyline.vertices.clear();
                in_polyline = true;
            } else if (entity.type == "VERTEX" && in_polyline) {
                polyline.vertices.push_back({{entity.number(10), entity.number(20)}, entity.number(42)});
            } else if (entity.type == "SEQEND" && in_polyline) {
                in_polyline = false;
                add(polyline);
            } else {
                add(entity);
            }
            entity = {};
        };
        while (groups_.next(group)) {
            if (group.code == 0) {
                if (in_entities) finish();
                after_section = group.value == "SECTION";
                if (group.value == "ENDSEC") in_entities = false;
                if (in_entities) {
                    entity.type = group.value;
                    entity.where = group.where;
                }
                continue;
            }
            if (after_section && group.code == 2) {
                in_entities = group.value == "ENTITIES";
                after_section = false;
            }
            if (in_entities && !entity.type.empty()) add_group(entity, group);
        }
        if (in_entities) {
            fail(source_, group.where, "the file ends inside its ENTITIES section; expected ENDSEC");
        }
    }

    void add_group(Entity& entity, const Group& group) {
        if (group.code == 8) entity.layer = group.value;
        const bool is_number = (group.code >= 10 && group.code <= 59) ||
                               (group.code >= 210 && group.code < 240) ||
                               (group.code >= 70 && group.code < 80);
        if (!is_number) return;
        std::string_view text = group.value;
        if (!text.empty() && text[0] == '+') text.remove_prefix(1);
        double value = 0;
        const auto result = std::from_chars(text.data(), text.data() + text.size(), value);
        if (result.ec != std::errc() || result.ptr != text.data() + text.size() || !std::isfinite(value)) {
            fail(source_, group.where,
                 "group " + std::to_string(group.code) + " of " + excerpt(entity.type) + " is '" +
                     excerpt(group.value) + "'; expected a finite number");
        }
        constexpr double kLargestFlags = 65535;
        if (group.code >= 70 && group.code < 80 && !(std::fabs(value) <= kLargestFlags)) {
            fail(source_, group.where,
                 "group " + std::to_string(group.code) + " of " + excerpt(entity.type) + " is " +
                     number_text(value) + "; expected a whole number of 16 bits");
        }
        entity.numbers[group.code] = value;
        if (entity.type != "LWPOLYLINE") return;
        if (group.code == 10) entity.vertices.push_back({{value, 0}, 0});
        if (entity.vertices.empty()) return;
        if (group.code == 20) entity.vertices.back().point[1] = value;
        if (group.code == 42) entity.vertices.back().bulge = value;
    }

    void add(const Entity& entity) {
        if (!options_.layer.empty() && entity.layer != options_.layer) return;
        std::vector<Vec2> path;
        const std::string_view type = entity.type;
        // What a mirrored coordinate system means for plane figures.
        const double mirror = type != "LINE" && type != "ELLIPSE" && entity.number(230, 1) < 0 ? -1 : 1;
        bool closed = false;
        const Vec2 at = {entity.number(10), entity.number(20)};
        if (type == "LINE") {
            path = {at, {entity.number(11), entity.number(21)}};
        } else if (type == "CIRCLE" || type == "ARC") {
            const double radius = entity.number(40);
            if (!(radius > 0)) fail_entity(entity, "the radius is " + number_text(radius));
            closed = type == "CIRCLE";
            double from = 0;
            double sweep = kTurn;
            if (!closed) {
                from = entity.number(50) * kTurn / 360;
                sweep = std::fmod(entity.number(51) * kTurn / 360 - from, kTurn);
                if (sweep <= 0) sweep += kTurn;
                from = std::fmod(from, kTurn);
            }
            add_arc(path, at, {radius, 0}, {0, radius}, from, sweep, !closed);
        } else if (type == "ELLIPSE") {
            const Vec2 major = {entity.number(11), entity.number(21)};
            const double ratio = entity.number(40, 1);
            if (!(std::hypot(major[0], major[1]) > 0) || !(ratio > 0)) {
                fail_entity(entity, "an axis is not longer than 0");
            }
            const double turn = entity.number(230, 1) < 0 ? -1 : 1;
            const Vec2 minor = {-major[1] * ratio * turn, major[0] * ratio * turn};
            const double from = std::fmod(entity.number(41, 0), kTurn);
            double sweep = std::fmod(entity.number(42, kTurn) - entity.number(41, 0), kTurn);
            if (sweep <= kTurn * 1e-9) sweep += kTurn;
            closed = sweep > kTurn * (1 - 1e-9);
            add_arc(path, at, major, minor, from, closed ? kTurn : sweep, !closed);
        } else if (type == "LWPOLYLINE" || type == "POLYLINE") {
            const int flags = static_cast<int>(entity.number(70));
            constexpr int kMeshes = 16 | 64;
            if (type == "POLYLINE" && (flags & kMeshes) != 0) {
                ++ignored_["mesh"];
                return;
            }
            closed = (flags & 1) != 0;
            add_polyline(path, entity.vertices, closed);
        } else if (type == "SPLINE" || type == "INSERT") {
            fail_entity(entity, type == "SPLINE"
                                    ? "splines are not read; convert them to polylines in the drawing program"
                                    : "inserted blocks are not read; explode them in the drawing program");
        } else {
            ++ignored_[excerpt(type)];
            return;
        }
        for (Vec2& point : path) point[0] *= mirror;
        if (path.size() < 2) return;
        (closed ? loops_ : paths_).push_back(std::move(path));
    }

    [[noreturn]] void fail_entity(const Entity& entity, const std::string& what) const {
        fail(source_, entity.where, std::string(entity.type) + ": " + what);
    }

    int pieces_of(double radius, double sweep) const {
        const int n = fragments_of(radius, options_.fn, options_.fa, options_.fs);
        const double wanted = std::ceil(n * std::fabs(sweep) / kTurn - 1e-9);
        return wanted > 2 ? static_cast<int>(wanted) : 2;  // 2 also for what is no number
    }

    void add_arc(std::vector<Vec2>& path, const Vec2& center, const Vec2& x, const Vec2& y, double from,
                 double sweep, bool with_end) const {
        const int n = pieces_of(std::hypot(x[0], x[1]), sweep);
        for (int i = 0; i < n + (with_end ? 1 : 0); ++i) {
            const double angle = from + sweep * i / n;
            const double c = std::cos(angle);
            const double s = std::sin(angle);
            path.push_back({center[0] + c * x[0] + s * y[0], center[1] + c * x[1] + s * y[1]});
        }
    }

    void add_polyline(std::vector<Vec2>& path, const std::vector<Entity::Vertex>& vertices,
                      bool closed) const {
        const std::size_t n = vertices.size();
        for (std::size_t i = 0; i < n; ++i) {
            const Vec2& p = vertices[i].point;
            path.push_back(p);
            if (std::fabs(vertices[i].bulge) < kStraightBulge || (i + 1 == n && !closed)) continue;
            const Vec2& q = vertices[(i + 1) % n].point;
            const double bulge = vertices[i].bulge;
            const Vec2 chord = {q[0] - p[0], q[1] - p[1]};
            const double length = std::hypot(chord[0], chord[1]);
            if (!(length > 0)) continue;
            // The centre lies left of the chord's middle at this part of the chord.
            const double aside = (1 - bulge * bulge) / (4 * bulge);
            const Vec2 center = {p[0] + chord[0] / 2 - chord[1] * aside,
                                 p[1] + chord[1] / 2 + chord[0] * aside};
            const Vec2 arm = {p[0] - center[0], p[1] - center[1]};
            const double sweep = 4 * std::atan(bulge);
            const int count = pieces_of(std::hypot(arm[0], arm[1]), sweep);
            for (int k = 1; k < count; ++k) {
                const double c = std::cos(sweep * k / count);
                const double s = std::sin(sweep * k / count);
                path.push_back({center[0] + c * arm[0] - s * arm[1], center[1] + s * arm[0] + c * arm[1]});
            }
        }
    }

    /// Numbers the ends of open paths: ends within kJoin of each other get the same number.
    std::vector<std::size_t> number_ends() const {
        std::vector<Vec2> ends;
        for (const auto& path : paths_) {
            ends.push_back(path.front());
            ends.push_back(path.back());
        }
        std::vector<std::size_t> order(ends.size());
        std::iota(order.begin(), order.end(), std::size_t{0});
        std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
            return ends[a] != ends[b] ? ends[a] < ends[b] : a < b;
        });
        std::vector<std::size_t> number(ends.size(), ends.size());
        for (std::size_t i = 0; i < order.size(); ++i) {
            if (number[order[i]] != ends.size()) continue;
            number[order[i]] = order[i];
            for (std::size_t j = i + 1; j < order.size() && ends[order[j]][0] - ends[order[i]][0] <= kJoin;
                 ++j) {
                if (number[order[j]] == ends.size() &&
                    std::fabs(ends[order[j]][1] - ends[order[i]][1]) <= kJoin) {
                    number[order[j]] = order[i];
                }
            }
        }
        return number;
    }

    /// Follows open paths from end to end; those that come back to their start become loops.
    void join() {
        const std::vector<std::size_t> number = number_ends();
        std::vector<std::vector<std::size_t>> at_end(number.size());  // ends at each number
        for (std::size_t end = 0; end < number.size(); ++end) at_end[number[end]].push_back(end);
        std::vector<char> used(paths_.size(), 0);
        // First from ends where only one path ends, so that open chains are followed as a whole.
        std::vector<std::size_t> starts;
        for (std::size_t end = 0; end < number.size(); ++end) {
            if (at_end[number[end]].size() == 1) starts.push_back(end);
        }
        for (std::size_t end = 0; end < number.size(); end += 2) starts.push_back(end);
        for (const std::size_t start : starts) {
            if (used[start / 2] != 0) continue;
            std::vector<Vec2> chain;
            std::size_t end = start;  // where the next path is entered
            bool closed = false;
            while (true) {
                std::vector<Vec2>& path = paths_[end / 2];
                used[end / 2] = 1;
                if (end % 2 == 1) std::reverse(path.begin(), path.end());
                chain.insert(chain.end(), path.begin() + (chain.empty() ? 0 : 1), path.end());
                const std::size_t here = number[end ^ 1U];
                if (here == number[start]) {
                    closed = true;
                    break;
                }
                const auto next = std::find_if(at_end[here].begin(), at_end[here].end(),
                                               [&](std::size_t other) { return used[other / 2] == 0; });
                if (next == at_end[here].end()) break;
                end = *next;
            }
            if (closed && chain.size() > 3) {
                chain.pop_back();
                loops_.push_back(std::move(chain));
            } else {
                ++open_;
            }
        }
    }

    GroupReader groups_;
    const std::string& source_;
    const DrawingOptions& options_;
    std::vector<std::vector<Vec2>> paths_;  ///< open
    Contours loops_;
    std::map<std::string, int> ignored_;
    std::size_t open_ = 0;
};

}  // namespace

std::vector<Contours> read_dxf(const std::string& content, const std::string& source,
                               const DrawingOptions& options, std::vector<std::string>& warnings) {
    constexpr std::string_view kBinary = "AutoCAD Binary DXF";
    if (content.compare(0, kBinary.size(), kBinary) == 0) {
        throw Error(ExitCode::kInput, source + ":1:1: binary DXF files are not read; save it as text");
    }
    return DxfReader(content, source, options).read(warnings);
}

void center_pieces(std::vector<Contours>& pieces) {
    Vec2 low = {HUGE_VAL, HUGE_VAL};
    Vec2 high = {-HUGE_VAL, -HUGE_VAL};
    const auto each_point = [&](auto&& visit) {
        for (Contours& piece : pieces) {
            for (auto& loop : piece) {
                for (Vec2& point : loop) visit(point);
            }
        }
    };
    each_point([&](const Vec2& point) {
        for (std::size_t k = 0; k < 2; ++k) {
            low[k] = std::min(low[k], point[k]);
            high[k] = std::max(high[k], point[k]);
        }
    });
    each_point([&](Vec2& point) {
        for (std::size_t k = 0; k < 2; ++k) point[k] -= (low[k] + high[k]) / 2;
    });
}

}  // namespace mortise::model_reader
