// The certificate's cells against exact arithmetic and independent volumes: positive simplices that fill
// what they should, faces that fit their neighbours, and templates that fit the certificate.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "host/snio/classify.hpp"
#include "kernels/shared/template_table.h"
#include "tests/cnio/cells.hpp"
#include "tests/mesher/random_models.hpp"
#include "tests/mesher/solids.hpp"
#include "tests/tape/bound_models.hpp"

using namespace mortise;
using namespace mortise::test;

namespace {

device::Device& shared_device() {
    static device::Device device("cpu");
    return device;
}

constexpr double kCellVolume6 = 6.0 * kCellUnits * kCellUnits * kCellUnits;

/// Six times the volume that a cell's elements fill, by region; every element is checked on the way.
std::vector<Exact> check_elements(const MeshedTree& mesh, const CellMesh& cell, std::size_t regions) {
    std::vector<Exact> filled(regions + 1, 0);
    for (std::size_t t = 0; t < kElementTypes; ++t) {
        const int size = kElementNodes[t];
        for (std::uint32_t i = 0; i < cell.record.element_count[t]; ++i) {
            const std::size_t element = cell.record.first_element[t] + i;
            const std::uint16_t region = mesh.arena.regions[t][element];
            REQUIRE(region >= 1);
            REQUIRE(region <= regions);
            Point p[8];
            bool inside = true;
            for (int k = 0; k < size; ++k) {
                const std::size_t at = element * static_cast<std::size_t>(size) + static_cast<std::size_t>(k);
                p[k] = mesh.position(cell, mesh.arena.nodes[t][at]);
                for (std::size_t j = 0; j < 3; ++j) {
                    const std::int64_t local = p[k][j] - cell.corner[j];
                    inside = inside && local >= 0 && local <= kCellUnits;
                }
            }
            REQUIRE(inside);
            const auto type = static_cast<ElementType>(t);
            REQUIRE(type != ElementType::kWedge);
            if (type == ElementType::kTetrahedron) {
                const Exact six = six_volume(p[0], p[1], p[2], p[3]);
                REQUIRE(static_cast<bool>(six > 0));
                filled[region] += six;
            } else if (type == ElementType::kPyramid) {
                for (int k = 0; k < 4; ++k) {
                    const Exact corner = six_volume(p[k], p[(k + 1) % 4], p[(k + 3) % 4], p[4]);
                    REQUIRE(static_cast<bool>(corner > 0));
                }
                // The base lies in a face of the cell, so it is planar.
                REQUIRE(static_cast<bool>(six_volume(p[0], p[1], p[2], p[3]) == 0));
                filled[region] += six_volume(p[0], p[1], p[2], p[4]) + six_volume(p[0], p[2], p[3], p[4]);
            } else {
                std::set<Point> corners(p, p + 8);
                REQUIRE(corners.size() == 8);
                for (int k = 0; k < 4; ++k) {
                    const Exact corner = six_volume(p[k], p[(k + 1) % 4], p[(k + 3) % 4], p[k + 4]);
                    REQUIRE(static_cast<bool>(corner > 0));
                }
                filled[region] += static_cast<Exact>(kCellVolume6);
            }
        }
    }
    return filled;
}

/// Six times the volume inside a cell's facets, by the divergence theorem about the cell's corner.
Exact enclosed(const MeshedTree& mesh, const CellMesh& cell, std::uint16_t region) {
    Exact total = 0;
    const auto add = [&](const std::array<std::uint16_t, 4>& node, int sign) {
        Point p[4];
        for (std::size_t k = 0; k < 4; ++k) p[k] = mesh.position(cell, node[k]);
        Exact six = six_volume(cell.corner, p[0], p[1], p[2]);
        if (node[3] != node[2]) six += six_volume(cell.corner, p[0], p[2], p[3]);
        total += sign * six;
    };
    for (int f = 0; f < 6; ++f) {
        // The face's frame is right-handed about +axis, except for y.
        const int outward = ((f & 1) != 0) == (f / 2 != 1) ? 1 : -1;
        const auto face = static_cast<std::size_t>(f);
        for (std::uint32_t i = cell.record.first_face_facet[4 * face];
             i < cell.record.first_face_facet[4 * face + 1]; ++i) {
            if (mesh.arena.face_facets[i].region == region) add(mesh.arena.face_facets[i].node, outward);
        }
    }
    for (std::uint32_t i = 0; i < cell.record.facet_count; ++i) {
        const cnio::InnerFacet& facet = mesh.arena.facets[cell.record.first_facet + i];
        REQUIRE(facet.inside != facet.outside);
        REQUIRE(facet.inside != 0);
        REQUIRE(facet.surface < mesh.model.surfaces.size());
        if (facet.inside == region) add(facet.node, 1);
        if (facet.outside == region) add(facet.node, -1);
    }
    return total;
}

void check_cells(const MeshedTree& mesh, std::size_t regions) {
    for (const CellMesh& cell : mesh.cells) {
        const auto filled = check_elements(mesh, cell, regions);
        Exact sum = 0;
        for (std::size_t r = 1; r <= regions; ++r) {
            sum += filled[r];
            REQUIRE(static_cast<bool>(enclosed(mesh, cell, static_cast<std::uint16_t>(r)) == filled[r]));
        }
        REQUIRE(static_cast<bool>(sum <= static_cast<Exact>(kCellVolume6)));
    }
}

bool untroubled(const cnio::CellCounters& counters) {
    return counters.refused == 0 && counters.limited == 0 && counters.unresolved == 0 &&
           counters.forced_caps == 0;
}

/// What two cells say of their common face: cells with features too fine may differ in regions, never in the
/// mesh.
struct FaceCounts {
    std::size_t compared = 0;
    std::size_t unexplained = 0;  ///< regions differ, but no surface holds the facet
    std::size_t too_fine = 0;     ///< the same beside a cell with features too fine
};

FaceCounts check_faces(const MeshedTree& mesh) {
    FaceCounts counts;
    const std::int64_t size = std::int64_t{1} << mesh.tree.level;
    for (const CellMesh& cell : mesh.cells) {
        for (int f = 0; f < 6; ++f) {
            const auto face = static_cast<std::size_t>(4 * f);  // whole faces have their first patch only
            const std::uint32_t first = cell.record.first_face_facet[face];
            const std::uint32_t last = cell.record.first_face_facet[face + 1];
            std::int64_t at[3];
            bool inside = true;
            for (int j = 0; j < 3; ++j) {
                at[j] = cell.corner[static_cast<std::size_t>(j)] >> kCellUnitBits;
                if (j == f / 2) at[j] += (f & 1) != 0 ? 1 : -1;
                inside = inside && at[j] >= 0 && at[j] < size;
            }
            if (!inside) continue;
            const std::uint64_t code =
                morton_encode(static_cast<u32>(at[0]), static_cast<u32>(at[1]), static_cast<u32>(at[2]));
            if (!mesh.tree.is_nio(code)) {
                // Nothing is cut there: one whole quadrilateral in the neighbour's region.
                REQUIRE(last - first == 1);
                for (std::size_t k = 0; k < 4; ++k) {
                    REQUIRE(mesh.arena.face_facets[first].node[k] == kFaceCorners[f][k]);
                }
                continue;
            }
            if ((f & 1) == 0) continue;  // each pair once
            const CellMesh& other = mesh.cells[mesh.tree.nio_index(code)];
            const std::uint32_t other_first = other.record.first_face_facet[face - 4];
            REQUIRE(other.record.first_face_facet[face - 3] - other_first == last - first);
            for (std::uint32_t i = 0; i < last - first; ++i) {
                const cnio::FaceFacet& a = mesh.arena.face_facets[first + i];
                const cnio::FaceFacet& b = mesh.arena.face_facets[other_first + i];
                REQUIRE((a.node[2] == a.node[3]) == (b.node[2] == b.node[3]));
                bool fits = true;
                for (std::size_t k = 0; k < 4; ++k) {
                    Point p{};
                    Point q{};
                    // A node that no element of a cell uses has no place there; its code tells corners and
                    // edges.
                    const bool known_a = mesh.locate(cell, a.node[k], p);
                    const bool known_b = mesh.locate(other, b.node[k], q);
                    fits = fits && (a.region == 0 || known_a) && (b.region == 0 || known_b) &&
                           (!known_a || !known_b || p == q) && (a.node[k] < 8) == (b.node[k] < 8) &&
                           (a.node[k] < cnio::kExtraCode) == (b.node[k] < cnio::kExtraCode);
                }
                REQUIRE(fits);
                ++counts.compared;
                if (a.region != b.region && a.surface == cnio::kNoSurface && b.surface == cnio::kNoSurface) {
                    ++(untroubled(cell.counters) && untroubled(other.counters) ? counts.unexplained
                                                                               : counts.too_fine);
                }
            }
        }
    }
    return counts;
}

/// Elements' volume of every cell against the exact one; returns the largest error in cell volumes.
double check_volumes(const Model& source, int level, double tolerance) {
    const MeshedTree mesh(shared_device(), source, level);
    const double size = mesh.tree.finest_edge();
    double worst = 0;
    for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
        const CellMesh& cell = mesh.cells[c];
        if (!untroubled(cell.counters)) continue;
        std::set<std::uint32_t> planes;
        const TreeNode& leaf = mesh.tree.nio[c];
        for (std::uint32_t i = 0; i < leaf.tape_length; ++i) {
            const std::uint32_t word = mesh.tree.tapes[leaf.tape_offset + i];
            if (tape_operation(word) == kTapeLiteral) planes.insert(tape_surface(word));
        }
        Vec3 corner{};
        for (std::size_t j = 0; j < 3; ++j)
            corner[j] = std::ldexp(static_cast<double>(cell.corner[j]), -level - kCellUnitBits);
        const auto expected =
            region_volumes(source, mesh.model, {planes.begin(), planes.end()}, corner, size);
        const auto filled = check_elements(mesh, cell, source.regions.size());
        for (std::size_t r = 1; r < expected.size(); ++r) {
            const double error =
                std::fabs(static_cast<double>(filled[r]) / kCellVolume6 - expected[r] / (size * size * size));
            CAPTURE(cell.morton);
            CAPTURE(planes.size());
            CAPTURE(error);
            CAPTURE(cell.counters.snapped);
            CHECK(error < tolerance);
            worst = std::max(worst, error);
        }
    }
    return worst;
}

}  // namespace

TEST_CASE("random models: every element positive, facets close the elements, faces fit") {
    std::size_t cells = 0;
    std::size_t troubled = 0;
    FaceCounts faces;
    for (std::uint64_t seed = 1; seed <= 30; ++seed) {
        const RandomModel source = make_random_model(seed);
        CAPTURE(seed);
        CAPTURE(source.style);
        try {
            const MeshedTree mesh(shared_device(), source.model, 3 + static_cast<int>(seed % 2));
            check_cells(mesh, source.model.regions.size());
            const FaceCounts counts = check_faces(mesh);
            faces.compared += counts.compared;
            faces.unexplained += counts.unexplained;
            faces.too_fine += counts.too_fine;
            for (const CellMesh& cell : mesh.cells) troubled += untroubled(cell.counters) ? 0 : 1;
            cells += mesh.cells.size();
        } catch (const Error& error) {
            CHECK(std::string(error.what()).find("empty") != std::string::npos);
        }
    }
    MESSAGE(cells << " cells, " << troubled << " with features too fine; " << faces.compared
                  << " facets compared, " << faces.unexplained + faces.too_fine
                  << " between two regions on no surface, " << faces.unexplained
                  << " of them not beside such a cell");
    CHECK(faces.compared > 10000);
}

TEST_CASE("formulas: every element positive, facets close the elements, faces fit") {
    for (const char* formula : {"(sqrt(x^2+y^2)-0.7)^2+z^2-0.09", "sin(5*x)*cos(5*y)+sin(5*z)-0.3",
                                "abs(x)+abs(y)+abs(z)-0.9", "min(x^2-0.2, max(y-0.3, z/(2+x)))"}) {
        CAPTURE(formula);
        const MeshedTree mesh(shared_device(), formula_model(formula, 1.2), 4);
        check_cells(mesh, 1);
        CHECK(check_faces(mesh).compared > 100);
    }
}

TEST_CASE("well-behaved models mesh without any trouble") {
    for (const Model& source : {rotated_box(), ball(), crossing_cylinders()}) {
        const MeshedTree mesh(shared_device(), source, 4);
        CHECK(mesh.counters.refused == 0);
        CHECK(mesh.counters.unresolved == 0);
        // A curved surface may bulge over a thin quadrilateral beside its chord: its cap then cannot have the
        // quadrilateral's signs. Planes do not.
        const bool planar = source.regions[0].name == "box";
        CHECK(mesh.counters.forced_caps <= (planar ? 0 : mesh.cells.size() / 50));
        CHECK(mesh.counters.snapped <= 2);  // roots beside an apex
        check_cells(mesh, 1);
        const FaceCounts counts = check_faces(mesh);
        CHECK(counts.compared > 500);
        CHECK(counts.unexplained == 0);
    }
}

TEST_CASE("convex polyhedra: each cell holds exactly the clipped solid") {
    double worst = 0;
    for (std::uint64_t seed = 1; seed <= 8; ++seed) {
        CAPTURE(seed);
        const Model source = random_polytope(seed, static_cast<int>(2 * seed));
        worst = std::max(worst, check_volumes(source, 3 + static_cast<int>(seed % 2), 1e-4));
    }
    MESSAGE("convex polyhedra: largest error " << worst << " of a cell");
}

TEST_CASE("polyhedra of boxes and wedges: each cell holds exactly its part of each region") {
    double worst = 0;
    for (std::uint64_t seed = 1; seed <= 16; ++seed) {
        CAPTURE(seed);
        worst = std::max(worst, check_volumes(random_polyhedron(seed), 4, 1e-4));
    }
    MESSAGE("polyhedra: largest error " << worst << " of a cell");
}

TEST_CASE("templates cover on each face of their cell what the certificate covers") {
    static constexpr int kSizes[4] = {8, 6, 5, 4};
    std::size_t templates = 0;
    for (const Model& source : {rotated_box(), ball(), crossing_cylinders(), random_polyhedron(4)}) {
        MeshedTree mesh(shared_device(), source, 4);
        const snio::Classification bins =
            snio::classify(shared_device(), mesh.tree, mesh.on_device, true, false);
        for (std::size_t c = 0; c < mesh.cells.size(); ++c) {
            const std::uint16_t pattern = bins.leaves[c].pattern;
            if (pattern == kPatternCnio) continue;
            const CellMesh& cell = mesh.cells[c];
            ++templates;
            // Facets of the template's elements that belong to one element only and lie on a face.
            std::map<std::vector<std::uint16_t>, int> facets;
            const TemplateRow& row = kTemplateRows[pattern];
            std::size_t at = row.first_node;
            if (pattern == 255) {
                for (const auto& corners : kFaceCorners) {
                    std::vector<std::uint16_t> key(corners, corners + 4);
                    std::sort(key.begin(), key.end());
                    ++facets[key];
                }
            } else if (pattern != 0) {
                for (std::size_t t = 0; t < 4; ++t) {
                    for (int i = 0; i < row.elements[t]; ++i, at += static_cast<std::size_t>(kSizes[t])) {
                        const LocalFaces faces = local_faces(static_cast<ElementType>(t));
                        for (int k = 0; k < faces.count; ++k) {
                            std::vector<std::uint16_t> key;
                            for (const int n : faces.faces[k]) {
                                if (n >= 0) key.push_back(kTemplateNodes[at + static_cast<std::size_t>(n)]);
                            }
                            std::sort(key.begin(), key.end());
                            ++facets[key];
                        }
                    }
                }
            }
            std::set<std::vector<std::uint16_t>> expected[6];
            for (const auto& [key, count] : facets) {
                if (count != 1) continue;
                for (int f = 0; f < 6; ++f) {
                    const bool on = std::all_of(key.begin(), key.end(), [f](std::uint16_t code) {
                        const auto corner_on = [f](int corner) { return (corner >> (f / 2) & 1) == (f & 1); };
                        if (code < 8) return corner_on(code);
                        if (code >= 20) return false;
                        return corner_on(kEdgeCorners[code - 8][0]) && corner_on(kEdgeCorners[code - 8][1]);
                    });
                    if (on) expected[f].insert(key);
                }
            }
            for (std::size_t f = 0; f < 6; ++f) {
                std::set<std::vector<std::uint16_t>> found;
                for (std::uint32_t i = cell.record.first_face_facet[4 * f];
                     i < cell.record.first_face_facet[4 * f + 1]; ++i) {
                    const cnio::FaceFacet& facet = mesh.arena.face_facets[i];
                    if (facet.region == 0) continue;
                    CHECK(facet.region == bins.leaves[c].region);
                    std::vector<std::uint16_t> key(facet.node.begin(), facet.node.end());
                    std::sort(key.begin(), key.end());
                    key.erase(std::unique(key.begin(), key.end()), key.end());
                    found.insert(key);
                }
                CAPTURE(pattern);
                CAPTURE(f);
                CHECK(found == expected[f]);
            }
        }
    }
    CHECK(templates > 500);
}
