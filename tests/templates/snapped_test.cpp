// Templates of cells with corners on the surface (kernels/shared/corner_choices.h), by measures and
// combinatorics of host/templates, which they do not use.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

#include "host/snio/face_plans.hpp"
#include "host/templates/measure.hpp"
#include "kernels/shared/corner_choices.h"
#include "kernels/shared/snap.h"
#include "tests/templates/table_access.hpp"

using namespace mortise::templates;
using namespace template_tests;

namespace {

/// A cell cut by a plane, some of its corners moved onto it.
struct PlaneCell {
    u32 inside = 0;
    u32 near = 0;  ///< corners that may move
    std::array<double, 8> distance{};
    Point normal{};
};

PlaneCell random_cell(Random& random) {
    PlaneCell cell;
    for (;;) {
        double square = 0;
        for (double& x : cell.normal) {
            x = 2 * random.uniform() - 1;
            square += x * x;
        }
        if (square > 1 || square < 1e-3) continue;
        for (double& x : cell.normal) x /= std::sqrt(square);
        break;
    }
    // Every fourth plane is nearly parallel to the grid or to a diagonal plane.
    if (random.uniform() < 0.25) {
        const double small = 0.1 * random.uniform() - 0.05;
        const double other = random.uniform() < 0.5 ? small : 1 + small;
        cell.normal = {small * small, other, 1};
        const double length = std::sqrt(small * small * small * small + other * other + 1);
        for (double& x : cell.normal) x /= length;
    }
    const auto& n = cell.normal;
    const double centre = 0.5 * (n[0] + n[1] + n[2]);
    const double reach = 0.5 * (std::fabs(n[0]) + std::fabs(n[1]) + std::fabs(n[2])) + kVertexSnapDistance;
    double offset = centre + reach * (2 * random.uniform() - 1);
    // Now and then just beside a corner, down to the least distance at which a corner moves.
    if (random.uniform() < 0.25) {
        const auto corner = static_cast<u32>(8 * random.uniform());
        const double decades = 5 * random.uniform();
        offset = (corner & 1) * n[0] + (corner >> 1 & 1) * n[1] + (corner >> 2) * n[2] +
                 (random.uniform() < 0.5 ? 1 : -1) * std::max(kSignTolerance, std::pow(0.1, decades));
    }
    for (u32 c = 0; c < 8; ++c) {
        const double d = (c & 1) * n[0] + (c >> 1 & 1) * n[1] + (c >> 2) * n[2] - offset;
        cell.distance[c] = d;
        if (d < 0) cell.inside |= 1U << c;
        if (std::fabs(d) < kVertexSnapDistance) cell.near |= 1U << c;
    }
    return cell;
}

/// Node positions with the corners of `on` moved; `noise` moves corners and cuts further.
Positions positions_of(const PlaneCell& cell, u32 on, double noise, Random& random) {
    Positions p{};
    for (std::size_t c = 0; c < 8; ++c) {
        for (std::size_t j = 0; j < 3; ++j) {
            p[c][j] = static_cast<double>(c >> j & 1);
            if ((on >> c & 1) != 0) {
                p[c][j] += noise * (2 * random.uniform() - 1) - cell.distance[c] * cell.normal[j];
            }
        }
    }
    for (std::size_t e = 0; e < 12; ++e) {
        const std::size_t low = kEdgeCorners[e][0], high = kEdgeCorners[e][1];
        for (std::size_t j = 0; j < 3; ++j) p[8 + e][j] = static_cast<double>(low >> j & 1);
        const double difference = cell.distance[low] - cell.distance[high];
        double t = difference != 0 ? cell.distance[low] / difference : 0.5;
        t += noise * (2 * random.uniform() - 1);
        p[8 + e][e / 4] = std::clamp(t, 1e-5, 1 - 1e-5);
    }
    return p;
}

/// The mesh of a face's polygon by the face rule.
int face_mesh_of(const u8* n, int count, u32 inside, const double (*p)[3]) {
    u8 meshes[kFaceMeshes];
    if (count == 0) return kFaceEmpty;
    face_meshes_by(face_rule(n, count, inside), n, p, meshes);
    return mesh_of_lane(meshes, 0);
}

struct Chosen {
    LeafTemplates found;
    int method = -1;
    Positions positions;
    std::vector<Element> elements;
    std::vector<Facet> boundary;  ///< outward
};

Element cone_over(const Facet& outward, u32 apex) {
    const Facet base = reversed(outward);
    Element element;
    element.type = outward.size == 4 ? ElementType::kPyramid : ElementType::kTetrahedron;
    for (std::size_t i = 0; i < static_cast<std::size_t>(outward.size); ++i) element.nodes[i] = base.nodes[i];
    element.nodes[static_cast<std::size_t>(outward.size)] = static_cast<NodeCode>(apex);
    return element;
}

Chosen choose(u32 inside, u32 on, const Positions& positions, u32 facing, u32 snapped = 0) {
    Chosen result;
    double p[kCellNodes][3];
    for (std::size_t i = 0; i < kCellNodes; ++i) std::copy(positions[i].begin(), positions[i].end(), p[i]);
    choose_templates(&mortise::snio::face_plans(), inside, on, snapped, p, facing, 0, &result.found);
    result.method = result.found.method[0];
    result.positions = positions;
    std::copy(p[kCellInteriorNode], p[kCellInteriorNode] + 3, result.positions[kCellInteriorNode].begin());
    if (result.method <= kMethodNothing) return result;
    take_meshes(&result.found, 0);
    const LeafTemplates& found = result.found;
    const Cones& cones = found.cones;
    if (result.method == kMethodRow) {
        result.elements = elements_of(static_cast<int>(inside));
        for (const Facet& facet : surface_of(static_cast<int>(inside))) result.boundary.push_back(facet);
    }
    for (int f = 0; f < 6; ++f) {
        for (int i = 0; i < facet_count(found.boundary.count[f], found.boundary.mesh[f]); ++i) {
            u8 n[4];
            const int size = face_facet(&found.boundary, f, i, n);
            result.boundary.push_back(
                reversed(size == 4 ? quad(n[0], n[1], n[2], n[3]) : triangle(n[0], n[1], n[2])));
        }
    }
    const std::size_t on_faces = result.boundary.size();
    if (result.method == kMethodCone || result.method == kMethodWedge) {
        for (u32 i = 0; i < cones.facet_count[0]; ++i) {
            const auto at = [&](int k) { return found.boundary.loop[cones.facets[0][i] >> (4 * k) & 15]; };
            result.boundary.push_back(at(2) != at(3) ? quad(at(0), at(1), at(2), at(3))
                                                     : triangle(at(0), at(1), at(2)));
        }
    }
    if (result.method == kMethodCone) {
        const auto apex = static_cast<NodeCode>(cones.apex[0]);
        if (apex == kInteriorNode) {
            std::copy(cones.point, cones.point + 3, result.positions[kInteriorNode].begin());
        }
        const auto loop_end = found.boundary.loop + found.boundary.loop_size;
        const bool on_loop = std::find(found.boundary.loop + 0, loop_end, apex) != loop_end;
        for (std::size_t i = 0; i < result.boundary.size(); ++i) {
            const Facet& facet = result.boundary[i];
            if ((node_set(facet) >> apex & 1U) != 0 || (on_loop && i >= on_faces)) continue;
            result.elements.push_back(cone_over(facet, apex));
        }
    }
    if (result.method == kMethodWedge) {
        int n[6];
        wedge_nodes(&found.boundary, static_cast<int>(cones.apex[0]), n);
        Element wedge;
        wedge.type = ElementType::kWedge;
        for (std::size_t i = 0; i < 6; ++i) wedge.nodes[i] = static_cast<NodeCode>(n[i]);
        result.elements.push_back(wedge);
    }
    if (result.method == kMethodHexahedron) {
        result.elements.push_back({ElementType::kHexahedron, {0, 1, 3, 2, 4, 5, 7, 6}});
    }
    return result;
}

/// Facets of elements that no other element has, as keys; empty if a facet occurs twice.
std::vector<std::uint32_t> open_facets(const std::vector<Element>& elements) {
    std::map<std::uint32_t, Facet> open;
    for (const Element& element : elements) {
        for (const Facet& facet : element_facets(element)) {
            if (open.erase(facet_key(reversed(facet))) != 0) continue;
            if (!open.emplace(facet_key(facet), facet).second) return {};
        }
    }
    std::vector<std::uint32_t> keys;
    for (const auto& item : open) keys.push_back(item.first);
    return keys;
}

/// Directed edges of the facets cancel in pairs.
bool is_closed(const std::vector<Facet>& facets) {
    std::map<std::pair<int, int>, int> edges;
    for (const Facet& facet : facets) {
        const auto size = static_cast<std::size_t>(facet.size);
        for (std::size_t i = 0; i < size; ++i) {
            const int a = facet.nodes[i], b = facet.nodes[(i + 1) % size];
            edges[{std::min(a, b), std::max(a, b)}] += a < b ? 1 : -1;
        }
    }
    return std::all_of(edges.begin(), edges.end(), [](const auto& edge) { return edge.second == 0; });
}

double six_volumes(const Point& a, const Point& b, const Point& c, const Point& d) {
    double e[3][3];
    for (std::size_t j = 0; j < 3; ++j) {
        e[0][j] = b[j] - a[j];
        e[1][j] = c[j] - a[j];
        e[2][j] = d[j] - a[j];
    }
    return e[0][0] * (e[1][1] * e[2][2] - e[1][2] * e[2][1]) +
           e[0][1] * (e[1][2] * e[2][0] - e[1][0] * e[2][2]) +
           e[0][2] * (e[1][0] * e[2][1] - e[1][1] * e[2][0]);
}

/// Whether a wedge's cones from all its nodes are positive, whichever diagonal divides the quadrilateral that
/// is opposite.
bool divides(const Element& wedge, const Positions& positions) {
    const auto at = [&](std::size_t k) { return positions[wedge.nodes[k]]; };
    for (std::size_t apex = 0; apex < 6; ++apex) {
        for (const Facet& facet : element_facets(wedge)) {
            std::array<Point, 4> p{};
            bool holds = false;
            for (std::size_t k = 0; k < static_cast<std::size_t>(facet.size); ++k) {
                p[k] = positions[facet.nodes[k]];
                holds = holds || facet.nodes[k] == wedge.nodes[apex];
            }
            if (holds) continue;
            // Outward facets.
            if (!(six_volumes(p[0], p[2], p[1], at(apex)) > 0)) return false;
            if (facet.size == 3) continue;
            if (!(six_volumes(p[0], p[3], p[2], at(apex)) > 0) ||
                !(six_volumes(p[0], p[3], p[1], at(apex)) > 0) ||
                !(six_volumes(p[1], p[3], p[2], at(apex)) > 0))
                return false;
        }
    }
    return true;
}

}  // namespace

TEST_CASE("all 6561 corner states: face meshes and the surface loop close up, and plans are the same") {
    int simple = 0;
    int closed = 0;
    Random random(70);
    const PlaneCell cell = random_cell(random);
    for (int code = 0; code < 6561; ++code) {
        u32 inside = 0;
        u32 on = 0;
        for (int c = 0, rest = code; c < 8; ++c, rest /= 3) {
            if (rest % 3 == 1) inside |= 1U << c;
            if (rest % 3 == 2) on |= 1U << c;
        }
        if (inside == 0) continue;
        CellBoundary boundary, planned;
        make_outline(inside, on, &boundary);
        double p[kCellNodes][3];
        const Positions positions = positions_of(cell, on, 0.1, random);
        for (std::size_t n = 0; n < kCellNodes; ++n)
            std::copy(positions[n].begin(), positions[n].end(), p[n]);
        planned_outline(&mortise::snio::face_plans(), inside, on, &planned);
        REQUIRE(planned.loop_size == boundary.loop_size);
        if (boundary.loop_size < 0) continue;
        REQUIRE(planned.nodes == boundary.nodes);
        REQUIRE(std::equal(planned.loop, planned.loop + planned.loop_size, boundary.loop));
        for (int f = 0; f < 6; ++f) {
            REQUIRE(planned.count[f] == boundary.count[f]);
            REQUIRE(std::equal(planned.node[f], planned.node[f] + planned.count[f], boundary.node[f]));
            const int rule =
                plan_of_face(&mortise::snio::face_plans(), inside, on, static_cast<u32>(f))->rule;
            REQUIRE(rule == face_rule(boundary.node[f], boundary.count[f], inside));
        }
        ++simple;
        // Every way to split the quadrilaterals.
        bool all_closed = true;
        for (int split = 0; split < 3; ++split) {
            std::vector<Facet> facets;
            for (int f = 0; f < 6; ++f) {
                const bool may_split = boundary.count[f] >= 4;
                boundary.mesh[f] = static_cast<u8>(boundary.count[f] == 0 ? kFaceEmpty
                                                   : may_split            ? 1 + split
                                                                          : 1);
                for (int i = 0; i < facet_count(boundary.count[f], boundary.mesh[f]); ++i) {
                    u8 n[4];
                    const int size = face_facet(&boundary, f, i, n);
                    facets.push_back(size == 4 ? quad(n[0], n[1], n[2], n[3]) : triangle(n[0], n[1], n[2]));
                }
            }
            for (int i = 1; i + 1 < boundary.loop_size; ++i) {
                facets.push_back(
                    reversed(triangle(boundary.loop[0], boundary.loop[i], boundary.loop[i + 1])));
            }
            all_closed = all_closed && is_closed(facets);
        }
        closed += all_closed ? 1 : 0;
    }
    CHECK(simple > 3000);
    CHECK(closed == simple);
}

TEST_CASE("without corners on the surface, outlines are those of the table's face rule") {
    for (int p = 1; p < 255; ++p) {
        if (!has_template(p)) continue;
        CAPTURE(p);
        CellBoundary boundary;
        make_outline(static_cast<u32>(p), 0, &boundary);
        CHECK(boundary.loop_size == static_cast<int>(surface_loop(static_cast<Pattern>(p)).size()));
        for (int f = 0; f < 6; ++f) {
            double q[kCellNodes][3] = {};
            boundary.mesh[f] =
                static_cast<u8>(face_mesh_of(boundary.node[f], boundary.count[f], static_cast<u32>(p), q));
            std::vector<Facet> facets;
            for (int i = 0; i < facet_count(boundary.count[f], boundary.mesh[f]); ++i) {
                u8 n[4];
                const int size = face_facet(&boundary, f, i, n);
                facets.push_back(
                    reversed(size == 4 ? quad(n[0], n[1], n[2], n[3]) : triangle(n[0], n[1], n[2])));
            }
            CHECK(sorted_keys(facets) == sorted_keys(face_facets(p, f)));
        }
    }
}

TEST_CASE("planes: quality of the cells with all near corners moved") {
    Random random(71);
    for (const double noise : {0.0, 0.01}) {
        Cosines extremes;
        double jacobian = 1;
        int cells = 0;
        int bad = 0;
        for (int i = 0; i < 40000; ++i) {
            const PlaneCell cell = random_cell(random);
            const u32 inside = cell.inside & ~cell.near;
            if (inside == 0 || inside == 255) continue;
            ++cells;
            const Chosen chosen = choose(inside, cell.near, positions_of(cell, cell.near, noise, random), 0);
            REQUIRE(chosen.method > kMethodNothing);
            std::vector<std::uint32_t> expected = sorted_keys(chosen.boundary);
            if (open_facets(chosen.elements) != expected) ++bad;
            double volume = 0;
            for (const Element& element : chosen.elements) {
                volume += enclosed_volume(element_facets(element), chosen.positions);
                if (!is_positive(element, chosen.positions)) ++bad;
                jacobian = std::min(jacobian, scaled_jacobian(element, chosen.positions));
                const Cosines cosines = dihedral_cosines(element, chosen.positions);
                extremes.smallest = std::min(extremes.smallest, cosines.smallest);
                extremes.largest = std::max(extremes.largest, cosines.largest);
            }
            if (std::fabs(volume - enclosed_volume(chosen.boundary, chosen.positions)) > 1e-12) ++bad;
        }
        MESSAGE("planes, noise ", noise, ": ", cells, " cells, dihedral ", degrees(extremes.largest), " to ",
                degrees(extremes.smallest), ", scaled Jacobian ", jacobian);
        CHECK(cells > 20000);
        CHECK(bad == 0);
        CHECK(degrees(extremes.largest) >= 15);
        CHECK(degrees(extremes.smallest) <= 160);
        CHECK(jacobian >= (noise > 0 ? 0.14 : 0.15));
    }
}

TEST_CASE("wedges can be divided along any diagonals") {
    Random random(74);
    int wedges = 0;
    int indivisible = 0;
    for (int i = 0; i < 200000; ++i) {
        const PlaneCell cell = random_cell(random);
        // Alike on both faces across the x axis, along which many of these planes are.
        const u32 low = 0x55 & static_cast<u32>(256 * random.uniform());
        const u32 on = cell.near & (low | low << 1);
        const u32 inside = cell.inside & ~on;
        if (inside == 0 || inside == 255) continue;
        const Chosen chosen = choose(inside, on, positions_of(cell, on, 0.2, random), 0, on);
        if (chosen.method != kMethodWedge) continue;
        ++wedges;
        indivisible += divides(chosen.elements.front(), chosen.positions) ? 0 : 1;
    }
    CHECK(wedges > 1000);
    CHECK(indivisible == 0);
    // Beside a crease: two corners are on it, two others have not moved though the surface is close.
    Positions positions{};
    for (std::size_t c = 0; c < 8; ++c) {
        for (std::size_t j = 0; j < 3; ++j) positions[c][j] = static_cast<double>(c >> j & 1);
    }
    positions[4] = {-0.0963, 0.0612, 1.2520};
    positions[6] = {0.2998, 0.9028, 1.2520};
    positions[8] = {0.0164, 0, 0};
    positions[9] = {0.4630, 1, 0};
    const Chosen twisted = choose(0x05, 0x50, positions, 0, 0x50);
    CHECK(twisted.method == -1);  // no cone is positive either
}

TEST_CASE("planes: every subset of the near corners has a valid template") {
    Random random(72);
    int subsets = 0;
    int missing = 0;
    int bad = 0;
    for (int i = 0; i < 6000; ++i) {
        const PlaneCell cell = random_cell(random);
        CornerChoices choices{};  // of all subsets, beside one of each
        u32 on = 0;
        do {
            const u32 inside = cell.inside & ~on;
            if (inside != 0) {
                ++subsets;
                const Positions positions = positions_of(cell, on, 0, random);
                double p[kCellNodes][3];
                for (std::size_t n = 0; n < kCellNodes; ++n) {
                    std::copy(positions[n].begin(), positions[n].end(), p[n]);
                }
                CornerChoices forgotten{};
                choices.stale = forgotten.stale = 0x3f;
                const LaneSet found =
                    have_templates(&mortise::snio::face_plans(), inside, on, on, kAllLanes, p, 0, &choices);
                if (found !=
                    have_templates(&mortise::snio::face_plans(), inside, on, on, kAllLanes, p, 0, &forgotten))
                    ++bad;
                if (found == 0) {
                    ++missing;
                } else {
                    const Chosen chosen = choose(inside, on, positions, 0);
                    if (open_facets(chosen.elements) != sorted_keys(chosen.boundary)) ++bad;
                    for (const Element& element : chosen.elements) {
                        if (!(scaled_jacobian(element, chosen.positions) > 0)) ++bad;
                    }
                }
            }
            on = (on - cell.near) & cell.near;
        } while (on != 0);
    }
    CHECK(subsets > 30000);
    CHECK(missing == 0);
    CHECK(bad == 0);
}

TEST_CASE("whatever is said to have a template has one, also where corners move too far") {
    Random random(73);
    int with = 0, without = 0;
    int wrong = 0;
    for (int i = 0; i < 6000; ++i) {
        const PlaneCell cell = random_cell(random);
        // Corners are somewhere, but at the same place in all choices.
        const Positions moved = positions_of(cell, cell.near, 0.6, random);
        const Positions still = positions_of(cell, 0, 0, random);
        CornerChoices choices{};
        u32 on = 0;
        do {
            const u32 inside = cell.inside & ~on;
            if (inside != 0) {
                Positions positions = still;
                for (std::size_t c = 0; c < 8; ++c) {
                    if ((on >> c & 1U) != 0) positions[c] = moved[c];
                }
                double p[kCellNodes][3];
                for (std::size_t n = 0; n < kCellNodes; ++n)
                    std::copy(positions[n].begin(), positions[n].end(), p[n]);
                choices.stale = 0x3f;
                const bool found = have_templates(&mortise::snio::face_plans(), inside, on, on, kAllLanes, p,
                                                  0, &choices) != 0;
                const bool chosen = choose(inside, on, positions, 0).method >= 0;
                ++(found ? with : without);
                if (found && !chosen) ++wrong;
            }
            on = (on - cell.near) & cell.near;
        } while (on != 0);
    }
    CHECK(with > 10000);
    CHECK(without > 1000);
    CHECK(wrong == 0);
}
