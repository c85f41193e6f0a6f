// SVG 1.1: path data (section 8.3), transforms (7.6), arcs by end points (F.6).
#include "host/model/outlines/svg_path.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <stdexcept>

#include "host/common/constants.hpp"
#include "host/model/outlines/outline_pieces.hpp"

namespace mortise::model_reader {
namespace {

/// Scans numbers, flags and letters.
class Scanner {
  public:
    explicit Scanner(std::string_view text) : text_(text) {}

    void skip() {
        while (at_ < text_.size() && (is_blank(text_[at_]) || text_[at_] == ',')) ++at_;
    }
    bool at_end() {
        skip();
        return at_ == text_.size();
    }
    char peek() {
        skip();
        return at_ < text_.size() ? text_[at_] : '\0';
    }
    void advance() { ++at_; }
    bool at_number() {
        const char c = peek();
        return (c >= '0' && c <= '9') || c == '-' || c == '+' || c == '.';
    }
    double number() {
        skip();
        std::size_t start = at_;
        if (start < text_.size() && text_[start] == '+') ++start;
        double value = 0;
        const auto result = std::from_chars(text_.data() + start, text_.data() + text_.size(), value);
        if (result.ec != std::errc() || !std::isfinite(value)) refuse("a number");
        at_ = static_cast<std::size_t>(result.ptr - text_.data());
        return value;
    }
    /// Flags of arcs may stand without a blank behind.
    bool flag() {
        const char c = peek();
        if (c != '0' && c != '1') refuse("0 or 1");
        ++at_;
        return c == '1';
    }
    std::string_view word() {
        skip();
        const std::size_t start = at_;
        while (at_ < text_.size() &&
               ((text_[at_] >= 'a' && text_[at_] <= 'z') || (text_[at_] >= 'A' && text_[at_] <= 'Z'))) {
            ++at_;
        }
        return text_.substr(start, at_ - start);
    }
    [[noreturn]] void refuse(const std::string& expected) {
        skip();
        throw std::invalid_argument("expected " + expected + ", found '" +
                                    std::string(text_.substr(at_, 20)) + "' in '" +
                                    std::string(text_.substr(0, 40)) + (text_.size() > 40 ? "...'" : "'"));
    }

  private:
    static bool is_blank(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }
    std::string_view text_;
    std::size_t at_ = 0;
};

class PathBuilder {
  public:
    explicit PathBuilder(const SvgFineness& fineness) : fineness_(fineness) {}

    SvgOutline take() {
        finish(true);
        return std::move(outline_);
    }
    const Vec2& at() const { return at_; }
    const Vec2& start() const { return start_; }

    void move_to(const Vec2& p) {
        finish(true);
        start_ = at_ = p;
        path_ = {p};
    }
    void close() {
        finish(false);
        at_ = start_;
        path_ = {start_};
    }
    void line_to(const Vec2& p) {
        path_.push_back(p);
        at_ = p;
    }
    void curve_to(const Vec2& b, const Vec2& c, const Vec2& d) {
        const Vec2 a = at_;
        const auto length = [](const Vec2& p, const Vec2& q) { return std::hypot(q[0] - p[0], q[1] - p[1]); };
        // As finely as a quarter of a circle of that length.
        const double along = length(a, b) + length(b, c) + length(c, d);
        const int n = pieces(along * 4 / kTurn, kTurn / 4);
        for (int i = 1; i < n; ++i) {
            const double t = static_cast<double>(i) / n;
            const double s = 1 - t;
            Vec2 point{};
            for (std::size_t k = 0; k < 2; ++k) {
                point[k] = s * s * s * a[k] + 3 * s * s * t * b[k] + 3 * s * t * t * c[k] + t * t * t * d[k];
            }
            path_.push_back(point);
        }
        line_to(d);
    }
    void arc_to(double rx, double ry, double degrees, bool large, bool sweep, const Vec2& to);

  private:
    int pieces(double radius, double angle) const {
        const DrawingOptions& o = fineness_.options;
        const int n = fragments_of(radius * fineness_.unit, o.fn, o.fa, o.fs);
        const double wanted = std::ceil(n * std::fabs(angle) / kTurn - 1e-9);
        return wanted > 2 ? static_cast<int>(wanted) : 2;  // 2 also for what is no number
    }
    void finish(bool open) {
        if (path_.size() > 1 && path_.front() == path_.back()) {
            path_.pop_back();
            open = false;
        }
        if (path_.size() > 2) {
            outline_.loops.push_back(path_);
            outline_.open.push_back(open ? 1 : 0);
        }
        path_.clear();
    }
    const SvgFineness& fineness_;
    SvgOutline outline_;
    std::vector<Vec2> path_;
    Vec2 at_{};
    Vec2 start_{};
};

void PathBuilder::arc_to(double rx, double ry, double degrees, bool large, bool sweep, const Vec2& to) {
    rx = std::fabs(rx);
    ry = std::fabs(ry);
    const Vec2 from = at_;
    if (!(rx > 0) || !(ry > 0) || from == to) {
        line_to(to);
        return;
    }
    const double c = std::cos(degrees * kTurn / 360);
    const double s = std::sin(degrees * kTurn / 360);
    // In the frame of the ellipse, about the chord's middle.
    const Vec2 half = {(from[0] - to[0]) / 2, (from[1] - to[1]) / 2};
    const double x = c * half[0] + s * half[1];
    const double y = c * half[1] - s * half[0];
    const double reach = std::hypot(x / rx, y / ry);
    if (reach > 1) {
        // Too small to reach: enlarged until it does.
        rx *= reach;
        ry *= reach;
    }
    double root = reach > 1 ? 0 : std::sqrt(std::max(0.0, 1 / std::max(reach * reach, 1e-300) - 1));
    if (large == sweep) root = -root;
    const Vec2 center = {root * rx * y / ry, -root * ry * x / rx};
    const double first = std::atan2((y - center[1]) / ry, (x - center[0]) / rx);
    const double last = std::atan2((-y - center[1]) / ry, (-x - center[0]) / rx);
    double angle = last - first;
    if (sweep && angle < 0) angle += kTurn;
    if (!sweep && angle > 0) angle -= kTurn;
    const int n = pieces(std::max(rx, ry), angle);
    for (int i = 1; i < n; ++i) {
        const double turn = first + angle * i / n;
        const double u = center[0] + rx * std::cos(turn);
        const double v = center[1] + ry * std::sin(turn);
        path_.push_back({(from[0] + to[0]) / 2 + c * u - s * v, (from[1] + to[1]) / 2 + s * u + c * v});
    }
    line_to(to);
}

Vec2 mirrored(const Vec2& p, const Vec2& about) { return {2 * about[0] - p[0], 2 * about[1] - p[1]}; }

}  // namespace

SvgMap svg_compose(const SvgMap& o, const SvgMap& i) {
    return {o[0] * i[0] + o[2] * i[1], o[1] * i[0] + o[3] * i[1],        o[0] * i[2] + o[2] * i[3],
            o[1] * i[2] + o[3] * i[3], o[0] * i[4] + o[2] * i[5] + o[4], o[1] * i[4] + o[3] * i[5] + o[5]};
}

std::vector<double> svg_numbers(std::string_view text) {
    Scanner scan(text);
    std::vector<double> numbers;
    while (!scan.at_end()) numbers.push_back(scan.number());
    return numbers;
}

SvgMap svg_transform(std::string_view text) {
    Scanner scan(text);
    SvgMap map = kSvgIdentity;
    while (!scan.at_end()) {
        const std::string name(scan.word());
        if (scan.peek() != '(') scan.refuse("a transform such as translate(1, 2)");
        scan.advance();
        std::vector<double> v;
        while (scan.peek() != ')') v.push_back(scan.number());
        scan.advance();
        SvgMap next = kSvgIdentity;
        const auto counts = [&](std::size_t least, std::size_t most) {
            return v.size() >= least && v.size() <= most;
        };
        if (name == "matrix" && counts(6, 6)) {
            std::copy(v.begin(), v.end(), next.begin());
        } else if (name == "translate" && counts(1, 2)) {
            next = {1, 0, 0, 1, v[0], v.size() > 1 ? v[1] : 0};
        } else if (name == "scale" && counts(1, 2)) {
            next = {v[0], 0, 0, v.size() > 1 ? v[1] : v[0], 0, 0};
        } else if (name == "rotate" && (counts(1, 1) || counts(3, 3))) {
            const double c = std::cos(v[0] * kTurn / 360);
            const double s = std::sin(v[0] * kTurn / 360);
            next = {c, s, -s, c, 0, 0};
            if (v.size() == 3) {
                next = svg_compose({1, 0, 0, 1, v[1], v[2]}, svg_compose(next, {1, 0, 0, 1, -v[1], -v[2]}));
            }
        } else if (name == "skewX" && counts(1, 1)) {
            next[2] = std::tan(v[0] * kTurn / 360);
        } else if (name == "skewY" && counts(1, 1)) {
            next[1] = std::tan(v[0] * kTurn / 360);
        } else {
            throw std::invalid_argument("the transform '" + name + "' with " + std::to_string(v.size()) +
                                        " numbers is not known");
        }
        map = svg_compose(map, next);
    }
    return map;
}

SvgOutline svg_path(std::string_view data, const SvgFineness& fineness) {
    Scanner scan(data);
    PathBuilder path(fineness);
    char command = '\0';
    Vec2 cubic_control{};      // of the last C or S
    Vec2 quadratic_control{};  // of the last Q or T
    char before = '\0';        // capital of the last command
    while (!scan.at_end()) {
        if (!scan.at_number()) {
            command = scan.peek();
            if (std::string_view("MmLlHhVvCcSsQqTtAaZz").find(command) == std::string_view::npos) {
                scan.refuse("a path command");
            }
            if (before == '\0' && command != 'M' && command != 'm') scan.refuse("the command M first");
            scan.advance();
        } else if (command == '\0' || command == 'Z' || command == 'z') {
            scan.refuse("a path command");
        }
        const bool relative = command >= 'a';
        const char kind = relative ? static_cast<char>(command - 'a' + 'A') : command;
        const Vec2 at = path.at();
        const auto point = [&] {
            Vec2 p = {scan.number(), 0};
            p[1] = scan.number();
            return relative ? Vec2{p[0] + at[0], p[1] + at[1]} : p;
        };
        switch (kind) {
            case 'M':
                path.move_to(point());
                command = relative ? 'l' : 'L';  // what further pairs mean
                break;
            case 'L': path.line_to(point()); break;
            case 'H': path.line_to({scan.number() + (relative ? at[0] : 0), at[1]}); break;
            case 'V': path.line_to({at[0], scan.number() + (relative ? at[1] : 0)}); break;
            case 'C':
            case 'S': {
                const bool follows = before == 'C' || before == 'S';
                const Vec2 first = kind == 'C' ? point() : follows ? mirrored(cubic_control, at) : at;
                const Vec2 second = point();
                path.curve_to(first, second, point());
                cubic_control = second;
                break;
            }
            case 'Q':
            case 'T': {
                const bool follows = before == 'Q' || before == 'T';
                const Vec2 control = kind == 'Q' ? point() : follows ? mirrored(quadratic_control, at) : at;
                const Vec2 to = point();
                path.curve_to({(at[0] + 2 * control[0]) / 3, (at[1] + 2 * control[1]) / 3},
                              {(to[0] + 2 * control[0]) / 3, (to[1] + 2 * control[1]) / 3}, to);
                quadratic_control = control;
                break;
            }
            case 'A': {
                const double rx = scan.number();
                const double ry = scan.number();
                const double degrees = scan.number();
                const bool large = scan.flag();
                const bool sweep = scan.flag();
                path.arc_to(rx, ry, degrees, large, sweep, point());
                break;
            }
            default: path.close(); break;
        }
        before = kind;
    }
    return path.take();
}

SvgOutline svg_ellipse(double cx, double cy, double rx, double ry, const SvgFineness& fineness) {
    PathBuilder path(fineness);
    path.move_to({cx + rx, cy});
    path.arc_to(rx, ry, 0, false, true, {cx, cy + ry});
    path.arc_to(rx, ry, 0, false, true, {cx - rx, cy});
    path.arc_to(rx, ry, 0, false, true, {cx, cy - ry});
    path.arc_to(rx, ry, 0, false, true, {cx + rx, cy});
    path.close();
    return path.take();
}

SvgOutline svg_rectangle(double x, double y, double width, double height, double rx, double ry,
                         const SvgFineness& fineness) {
    PathBuilder path(fineness);
    rx = std::min(rx, width / 2);
    ry = std::min(ry, height / 2);
    const double right = x + width;
    const double bottom = y + height;
    path.move_to({x + rx, y});
    path.line_to({right - rx, y});
    path.arc_to(rx, ry, 0, false, true, {right, y + ry});
    path.line_to({right, bottom - ry});
    path.arc_to(rx, ry, 0, false, true, {right - rx, bottom});
    path.line_to({x + rx, bottom});
    path.arc_to(rx, ry, 0, false, true, {x, bottom - ry});
    path.line_to({x, y + ry});
    path.arc_to(rx, ry, 0, false, true, {x + rx, y});
    path.close();
    return path.take();
}

}  // namespace mortise::model_reader
