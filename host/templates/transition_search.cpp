// The search for the fewest elements that fill a transition cell: branch and bound over the facets that still
// lack an element on one side.
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "host/common/random.hpp"
#include "host/templates/transition.hpp"
#include "mortise/mesh.hpp"

namespace mortise::templates {
namespace {

/// Places of branch and bound looked at for one class; beyond, the best so far stays.
constexpr int kMostSteps = 30000;

constexpr int kSampleWords = 3;
using Samples = std::array<std::uint64_t, kSampleWords>;
using Nodes = std::array<std::uint8_t, 4>;  ///< of a facet, ascending; a triangle ends with 255

struct Side {
    int facet;
    int sign;  ///< which side of the facet the element is on
};

struct Candidate {
    TransitionElement element;
    double scaled_jacobian = 0;
    std::uint32_t nodes = 0;
    Samples inside{};  ///< sample points in the element: two that overlap share some
    std::vector<Side> sides;
};

GridPoint minus(int a, int b) {
    const GridPoint p = grid_point(a);
    const GridPoint q = grid_point(b);
    return {p[0] - q[0], p[1] - q[1], p[2] - q[2]};
}
GridPoint cross(const GridPoint& a, const GridPoint& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
int dot(const GridPoint& a, const GridPoint& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
int determinant(int a, int b, int c, int d) { return dot(cross(minus(b, a), minus(c, a)), minus(d, a)); }

bool is_plane_and_convex(const std::array<int, 4>& q) {
    if (determinant(q[0], q[1], q[2], q[3]) != 0) return false;
    GridPoint first{};
    for (std::size_t i = 0; i < 4; ++i) {
        const int b = q[(i + 1) % 4];
        const GridPoint normal = cross(minus(b, q[i]), minus(q[(i + 2) % 4], b));
        if (i == 0) first = normal;
        if (dot(normal, first) <= 0) return false;
    }
    return true;
}

/// All elements with plane faces and vertices of the grid that keep the limits.
class Candidates {
  public:
    Candidates() {
        // Points that lie on no plane through three vertices.
        Random random(1);
        for (auto& point : samples_) {
            for (double& x : point) x = 2 * random.uniform();
        }
        add_tetrahedra();
        find_quads();
        add_pyramids();
        add_wedges();
        add_hexahedra();
    }
    const std::vector<Candidate>& all() const { return all_; }
    std::size_t facet_count() const { return facets_.size(); }

    /// The facet and on which side of it an element lies from which it is seen as given.
    Side side_of(const std::uint8_t* node, std::size_t count) {
        Nodes key = {node[0], node[1], node[2], count == 4 ? node[3] : std::uint8_t{255}};
        std::sort(key.begin(), key.end());
        const GridPoint normal = cross(minus(node[1], node[0]), minus(node[2], node[0]));
        const auto found = facets_.insert({key, static_cast<int>(facets_.size())}).first;
        for (const int x : normal) {
            if (x != 0) return {found->second, x > 0 ? 1 : -1};
        }
        return {found->second, 0};
    }

  private:
    void add(std::initializer_list<int> node) {
        Candidate candidate;
        for (const int n : node) {
            if (((candidate.nodes >> n) & 1) != 0) return;
            candidate.nodes |= 1u << n;
            candidate.element.node[candidate.element.count++] = static_cast<std::uint8_t>(n);
        }
        const TransitionFigures figures = transition_figures(candidate.element);
        if (!(figures.scaled_jacobian >= kTransitionScaledJacobian &&
              figures.smallest_angle >= kTransitionSmallestAngle &&
              figures.largest_angle <= kTransitionLargestAngle)) {
            return;
        }
        candidate.scaled_jacobian = figures.scaled_jacobian;
        const int count = candidate.element.count;
        const LocalFaces faces = local_faces(count == 8   ? ElementType::kHexahedron
                                             : count == 6 ? ElementType::kWedge
                                             : count == 5 ? ElementType::kPyramid
                                                          : ElementType::kTetrahedron);
        candidate.inside.fill(~std::uint64_t{0});
        for (int f = 0; f < faces.count; ++f) {
            const LocalFace& face = faces.faces[f];
            std::uint8_t at[4];
            const std::size_t size = corner_count(face);
            for (std::size_t i = 0; i < size; ++i)
                at[i] = candidate.element.node[static_cast<std::size_t>(face[i])];
            candidate.sides.push_back(side_of(at, size));
            const GridPoint normal = cross(minus(at[1], at[0]), minus(at[2], at[0]));
            const GridPoint origin = grid_point(at[0]);
            for (std::size_t s = 0; s < samples_.size(); ++s) {
                double height = 0;
                for (std::size_t j = 0; j < 3; ++j) height += normal[j] * (samples_[s][j] - origin[j]);
                if (height > 0) candidate.inside[s / 64] &= ~(std::uint64_t{1} << (s % 64));
            }
        }
        all_.push_back(candidate);
    }
    void add_tetrahedra() {
        for (int a = 0; a < kGridVertices; ++a) {
            for (int b = a + 1; b < kGridVertices; ++b) {
                for (int c = b + 1; c < kGridVertices; ++c) {
                    for (int d = c + 1; d < kGridVertices; ++d) {
                        const int volume = determinant(a, b, c, d);
                        if (volume > 0) add({a, b, c, d});
                        if (volume < 0) add({b, a, c, d});
                    }
                }
            }
        }
    }
    void find_quads() {
        for (int a = 0; a < kGridVertices; ++a) {
            for (int b = 0; b < kGridVertices; ++b) {
                for (int c = 0; c < kGridVertices; ++c) {
                    if (a == b || b == c || a == c) continue;
                    for (int d = 0; d < kGridVertices; ++d) {
                        if (!is_plane_and_convex({a, b, c, d})) continue;
                        beyond_[a][b].push_back({c, d});
                        quads_.insert({a, b, c, d});
                    }
                }
            }
        }
    }
    void add_pyramids() {
        for (const auto& q : quads_) {
            if (q[0] != std::min({q[0], q[1], q[2], q[3]})) continue;
            for (int apex = 0; apex < kGridVertices; ++apex) {
                if (determinant(q[0], q[1], q[2], apex) > 0) add({q[0], q[1], q[2], q[3], apex});
            }
        }
    }
    void add_wedges() {
        for (int a = 0; a < kGridVertices; ++a) {
            for (int b = a + 1; b < kGridVertices; ++b) {
                for (const auto& [e, d] : beyond_[a][b]) {
                    if (d < a || e < a) continue;
                    for (int c = a + 1; c < kGridVertices; ++c) {
                        if (determinant(a, b, c, d) <= 0) continue;
                        for (const auto& [f, at] : beyond_[b][c]) {
                            if (at == e && f > a && quads_.count({c, a, d, f}) != 0) add({a, b, c, d, e, f});
                        }
                    }
                }
            }
        }
    }
    void add_hexahedra() {
        std::set<std::uint32_t> seen;
        for (const auto& q : quads_) {
            const auto [a, b, c, d] = q;
            if (a != std::min({a, b, c, d})) continue;
            for (const auto& [f, e] : beyond_[a][b]) {
                if (e < a || f < a || determinant(a, b, c, e) <= 0) continue;
                for (const auto& [g, at_f] : beyond_[b][c]) {
                    if (at_f != f || g < a) continue;
                    for (const auto& [h, at_g] : beyond_[c][d]) {
                        if (at_g != g || h < a || quads_.count({d, a, e, h}) == 0 ||
                            quads_.count({e, f, g, h}) == 0) {
                            continue;
                        }
                        const std::uint32_t nodes =
                            1u << a | 1u << b | 1u << c | 1u << d | 1u << e | 1u << f | 1u << g | 1u << h;
                        if (seen.insert(nodes).second) add({a, b, c, d, e, f, g, h});
                    }
                }
            }
        }
    }

    std::array<std::array<double, 3>, 64 * kSampleWords> samples_{};
    std::vector<Candidate> all_;
    std::map<Nodes, int> facets_;
    std::set<std::array<int, 4>> quads_;
    std::vector<std::pair<int, int>> beyond_[kGridVertices][kGridVertices];  ///< quads from an edge on
};

bool is_on_surface(std::uint32_t nodes) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
        for (const int side : {0, 2}) {
            bool all = true;
            for (int v = 0; v < kGridVertices; ++v)
                all = all && (((nodes >> v) & 1) == 0 || grid_point(v)[axis] == side);
            if (all) return true;
        }
    }
    return false;
}

/// Branch and bound for one class.
class Search {
  public:
    Search(Candidates& candidates, SplitPattern pattern) : all_(candidates.all()) {
        std::uint32_t present = 1u << kGridCentre;
        for (int v = 0; v < 27; v += 2) {
            const GridPoint p = grid_point(v);
            if (p[0] != 1 && p[1] != 1 && p[2] != 1) present |= 1u << v;
        }
        for (int b = 0; b < kSplitBits; ++b) {
            if (((pattern >> b) & 1) != 0) present |= 1u << split_vertex(b);
        }
        std::vector<Side> surface;
        for (const TransitionElement& facet : transition_facets(pattern))
            surface.push_back(candidates.side_of(facet.node.data(), facet.count));
        wanted_.assign(candidates.facet_count(), 0);
        weight_.assign(wanted_.size(), 0);
        by_side_.resize(2 * wanted_.size());
        for (const Side& side : surface) {
            wanted_[static_cast<std::size_t>(side.facet)] = static_cast<signed char>(side.sign);
            open_.push_back(side.facet);
        }
        for (std::size_t i = 0; i < all_.size(); ++i) {
            const Candidate& c = all_[i];
            if ((c.nodes & ~present) != 0) continue;
            bool fits = true;
            int own = 0;
            const LocalFaces faces = faces_of(c);
            for (std::size_t s = 0; s < c.sides.size(); ++s) {
                const int here = wanted_[static_cast<std::size_t>(c.sides[s].facet)];
                if (here != 0) {
                    fits = fits && here == c.sides[s].sign;
                    ++own;
                    continue;
                }
                std::uint32_t nodes = 0;
                for (const int n : faces.faces[s]) {
                    if (n >= 0) nodes |= 1u << c.element.node[static_cast<std::size_t>(n)];
                }
                fits = fits && !is_on_surface(nodes);
            }
            if (!fits) continue;
            for (const Side& side : c.sides) {
                by_side_[slot(side.facet, side.sign)].push_back(static_cast<int>(i));
                double& weight = weight_[static_cast<std::size_t>(side.facet)];
                if (wanted_[static_cast<std::size_t>(side.facet)] != 0)
                    weight = weight == 0 ? 1.0 / own : std::min(weight, 1.0 / own);
            }
        }
        for (const Side& side : surface) bound_ += weight_[static_cast<std::size_t>(side.facet)];
    }

    void run(TransitionClass& result) {
        result.elements = transition_cone(result.pattern);
        fewest_ = result.elements.size();
        best_worst_ = 1;
        for (const TransitionElement& e : result.elements)
            best_worst_ = std::min(best_worst_, transition_figures(e).scaled_jacobian);
        descend(bound_, 1);
        result.is_fewest = steps_ < kMostSteps;
        if (best_.empty()) return;
        result.elements.clear();
        for (const int i : best_) result.elements.push_back(all_[static_cast<std::size_t>(i)].element);
    }

  private:
    static std::size_t slot(int facet, int sign) {
        return 2 * static_cast<std::size_t>(facet) + (sign > 0 ? 1 : 0);
    }
    static LocalFaces faces_of(const Candidate& c) {
        return local_faces(c.element.count == 8   ? ElementType::kHexahedron
                           : c.element.count == 6 ? ElementType::kWedge
                           : c.element.count == 5 ? ElementType::kPyramid
                                                  : ElementType::kTetrahedron);
    }
    bool fits(const Candidate& c) const {
        for (std::size_t w = 0; w < kSampleWords; ++w) {
            if ((c.inside[w] & covered_[w]) != 0) return false;
        }
        return std::all_of(c.sides.begin(), c.sides.end(), [this](const Side& side) {
            const int here = wanted_[static_cast<std::size_t>(side.facet)];
            return here == 0 || here == side.sign;
        });
    }

    /// `left`: elements needed at least for the cube's own facets that are still open.
    void descend(double left, double worst) {
        if (open_.empty()) {
            if (chosen_.size() < fewest_ || worst > best_worst_ + 1e-9) {
                fewest_ = chosen_.size();
                best_worst_ = worst;
                best_ = chosen_;
            }
            return;
        }
        const std::size_t needed =
            chosen_.size() + std::max<std::size_t>(1, static_cast<std::size_t>(std::ceil(left - 1e-9)));
        if (needed > fewest_ || (needed == fewest_ && worst <= best_worst_ + 1e-9)) return;
        if (++steps_ >= kMostSteps) return;
        // The open facet with the fewest ways to go on.
        std::vector<int> ways;
        std::vector<int> some;
        bool found = false;
        for (const int facet : open_) {
            some.clear();
            const int sign = wanted_[static_cast<std::size_t>(facet)];
            for (const int i : by_side_[slot(facet, sign)]) {
                if (!fits(all_[static_cast<std::size_t>(i)])) continue;
                some.push_back(i);
                if (found && some.size() >= ways.size()) break;
            }
            if (found && some.size() >= ways.size()) continue;
            ways = some;
            found = true;
            if (ways.empty()) return;
        }
        // Those that close most first, then the best shaped.
        const auto closed_by = [this](int i) {
            int closed = 0;
            for (const Side& side : all_[static_cast<std::size_t>(i)].sides)
                closed += wanted_[static_cast<std::size_t>(side.facet)] != 0 ? 1 : -1;
            return closed;
        };
        std::sort(ways.begin(), ways.end(), [&](int a, int b) {
            const int ca = closed_by(a);
            const int cb = closed_by(b);
            if (ca != cb) return ca > cb;
            const double qa = all_[static_cast<std::size_t>(a)].scaled_jacobian;
            const double qb = all_[static_cast<std::size_t>(b)].scaled_jacobian;
            return qa != qb ? qa > qb : a < b;
        });
        for (const int i : ways) {
            const Candidate& c = all_[static_cast<std::size_t>(i)];
            const std::vector<int> open_before = open_;
            const Samples covered_before = covered_;
            double less = left;
            for (const Side& side : c.sides) {
                signed char& here = wanted_[static_cast<std::size_t>(side.facet)];
                if (here != 0) {
                    here = 0;
                    less -= weight_[static_cast<std::size_t>(side.facet)];
                    open_.erase(std::find(open_.begin(), open_.end(), side.facet));
                } else {
                    here = static_cast<signed char>(-side.sign);
                    open_.push_back(side.facet);
                }
            }
            for (std::size_t w = 0; w < kSampleWords; ++w) covered_[w] |= c.inside[w];
            chosen_.push_back(i);
            descend(less, std::min(worst, c.scaled_jacobian));
            chosen_.pop_back();
            covered_ = covered_before;
            for (const Side& side : c.sides) wanted_[static_cast<std::size_t>(side.facet)] = 0;
            for (const Side& side : c.sides) {
                if (std::find(open_before.begin(), open_before.end(), side.facet) != open_before.end())
                    wanted_[static_cast<std::size_t>(side.facet)] = static_cast<signed char>(side.sign);
            }
            open_ = open_before;
        }
    }

    const std::vector<Candidate>& all_;
    std::vector<signed char> wanted_;  ///< by facet: the side that lacks an element; 0: closed, or not in use
    std::vector<double> weight_;       ///< by facet of the cube: least share of it in an element
    std::vector<std::vector<int>> by_side_;
    std::vector<int> open_;
    Samples covered_{};
    std::vector<int> chosen_;
    std::vector<int> best_;
    double bound_ = 0;
    double best_worst_ = 0;
    std::size_t fewest_ = 0;
    int steps_ = 0;
};

}  // namespace

std::vector<TransitionClass> build_transitions() {
    Candidates candidates;
    std::vector<TransitionClass> classes;
    for (SplitPattern pattern = 0; pattern < 1u << kSplitBits; ++pattern) {
        if (!is_split_pattern(pattern)) continue;
        bool smallest = true;
        for (const CubeSymmetry& symmetry : cube_symmetries())
            smallest = smallest && transform(symmetry, pattern) >= pattern;
        if (!smallest) continue;
        TransitionClass row;
        row.pattern = pattern;
        Search(candidates, pattern).run(row);
        classes.push_back(row);
    }
    return classes;
}

}  // namespace mortise::templates
