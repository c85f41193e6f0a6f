#include "host/improve/split_elements.hpp"

#include <algorithm>

#include "host/common/large_array.hpp"
#include "host/common/parallel.hpp"
#include "host/improve/zone_facets.hpp"

namespace mortise::improve {
namespace {

constexpr std::size_t kSplitChunk = 4096;
/// A split into tetrahedra that is flatter than this is replaced by a cone from the element's centre.
constexpr double kLowestSplit = 0.02;
/// New nodes are numbered from here on until it is known how many other chunks have.
constexpr ZoneNode kCentre = 0x80000000u;

/// What one chunk of the elements becomes.
struct Pieces {
    std::vector<Tetrahedron> tetrahedra;
    std::vector<Pyramid> pyramids;
    std::vector<Point> centres;
    std::vector<std::uint8_t> centre_class;
    std::vector<CellId> refused;
};

class Splitter {
  public:
    Splitter(const Mesh& mesh, const CellFrame& frame, const CellSet& cells, const ZoneNodes& place,
             const Zone& zone)
        : mesh_(mesh), frame_(frame), cells_(cells), place_(place), zone_(zone) {}

    void split(const ElementRef& r, Pieces& out) const {
        const Element e = element(mesh_, r.type, r.index);
        if (e.type == ElementType::kTetrahedron) {
            out.tetrahedra.push_back(labelled<Tetrahedron>(r));
            for (std::size_t k = 0; k < 4; ++k) out.tetrahedra.back().node[k] = place_[e.node[k]];
            return;
        }
        if (e.type == ElementType::kPyramid && r.kept != 0) {
            out.pyramids.push_back(labelled<Pyramid>(r));
            for (std::size_t k = 0; k < 5; ++k) out.pyramids.back().node[k] = place_[e.node[k]];
            return;
        }
        const ZoneNode lowest = place_[*std::min_element(e.node, e.node + e.count)];
        if (r.kept == 0 && cone(r, lowest, zone_.points[lowest], kLowestSplit, out)) return;
        const Point centre = centroid(mesh_, frame_, e);
        if (cone(r, kCentre + static_cast<ZoneNode>(out.centres.size()), centre, 0, out)) {
            out.centres.push_back(centre);
            out.centre_class.push_back(static_cast<std::uint8_t>(cells_.size_class(r.cell)));
            return;
        }
        if (r.kept == 0 && cone(r, lowest, zone_.points[lowest], 0, out)) return;
        out.refused.push_back(r.cell);
    }

  private:
    template <class Piece>
    Piece labelled(const ElementRef& r) const {
        Piece piece;
        piece.region = mesh_.elements[r.type].region[r.index];
        piece.kind = mesh_.elements[r.type].kind[r.index];
        return piece;
    }

    const Point& at(NodeId node) const { return zone_.points[place_[node]]; }

    /// The cone from `apex`, a node of the element or a new one; false, and nothing is made, if a piece is
    /// flatter than `floor`.
    bool cone(const ElementRef& r, ZoneNode apex, const Point& tip, double floor, Pieces& out) const {
        const std::size_t tetrahedra = out.tetrahedra.size();
        const std::size_t pyramids = out.pyramids.size();
        if (add_cone(r, apex, tip, floor, out)) return true;
        out.tetrahedra.resize(tetrahedra);
        out.pyramids.resize(pyramids);
        return false;
    }

    bool add_cone(const ElementRef& r, ZoneNode apex, const Point& tip, double floor, Pieces& out) const {
        const Element e = element(mesh_, r.type, r.index);
        const LocalFaces faces = local_faces(e.type);
        for (int f = 0; f < faces.count; ++f) {
            const LocalFace& face = faces.faces[f];
            const std::size_t count = corner_count(face);
            NodeId node[4] = {};
            bool holds = false;
            for (std::size_t k = 0; k < count; ++k) {
                node[k] = e.node[face[k]];
                holds = holds || place_[node[k]] == apex;
            }
            if (holds) continue;
            if (count == 4 && ((r.kept >> f) & 1) != 0) {
                Pyramid p = labelled<Pyramid>(r);
                for (std::size_t k = 0; k < 4; ++k) p.node[k] = place_[node[3 - k]];
                p.node[4] = apex;
                if (!(pyramid_quality({at(node[3]), at(node[2]), at(node[1]), at(node[0]), tip}) > floor))
                    return false;
                out.pyramids.push_back(p);
                continue;
            }
            std::array<std::array<NodeId, 3>, 2> triangles = {{{node[0], node[1], node[2]}, {}}};
            if (count == 4) triangles = halves(node);
            for (std::size_t k = 0; k < count - 2; ++k) {
                const auto& n = triangles[k];
                Tetrahedron t = labelled<Tetrahedron>(r);
                t.node = {place_[n[0]], place_[n[2]], place_[n[1]], apex};
                if (!(tetrahedron_quality(at(n[0]), at(n[2]), at(n[1]), tip, zone_.rounding) > floor))
                    return false;
                out.tetrahedra.push_back(t);
            }
        }
        return true;
    }

    const Mesh& mesh_;
    const CellFrame& frame_;
    const CellSet& cells_;
    const ZoneNodes& place_;
    const Zone& zone_;
};

/// Copies pieces whose new nodes get their numbers: centre `kCentre` becomes node `first`.
template <class Piece>
void copy(const std::vector<Piece>& pieces, ZoneNode first, Piece* out) {
    for (Piece piece : pieces) {
        for (ZoneNode& n : piece.node) {
            if (n >= kCentre) n = first + (n - kCentre);
        }
        *out++ = piece;
    }
}

}  // namespace

std::vector<CellId> split_elements(const Mesh& mesh, const CellFrame& frame, const CellSet& cells,
                                   const std::vector<ElementRef>& elements, const ZoneNodes& place,
                                   int threads, Zone& zone) {
    const Splitter splitter(mesh, frame, cells, place, zone);
    std::vector<Pieces> parts(chunk_count(elements.size(), kSplitChunk));
    parallel_chunks(elements.size(), kSplitChunk, threads, [&](std::size_t begin, std::size_t end, int) {
        for (std::size_t i = begin; i < end; ++i) splitter.split(elements[i], parts[begin / kSplitChunk]);
    });
    struct Begin {
        std::size_t tetrahedra, pyramids;
        ZoneNode centres;
    };
    std::vector<Begin> begins;
    Begin next = {0, 0, static_cast<ZoneNode>(zone.points.size())};
    std::vector<CellId> refused;
    for (const Pieces& part : parts) {
        begins.push_back(next);
        next.tetrahedra += part.tetrahedra.size();
        next.pyramids += part.pyramids.size();
        next.centres += static_cast<ZoneNode>(part.centres.size());
        zone.points.insert(zone.points.end(), part.centres.begin(), part.centres.end());
        zone.size_class.insert(zone.size_class.end(), part.centre_class.begin(), part.centre_class.end());
        refused.insert(refused.end(), part.refused.begin(), part.refused.end());
    }
    zone.mesh_node.resize(zone.points.size(), kNone);
    resize_large(zone.tetrahedra, next.tetrahedra, threads);
    zone.pyramids.resize(next.pyramids);
    parallel_chunks(parts.size(), 1, threads, [&](std::size_t i, std::size_t, int) {
        copy(parts[i].tetrahedra, begins[i].centres, zone.tetrahedra.data() + begins[i].tetrahedra);
        copy(parts[i].pyramids, begins[i].centres, zone.pyramids.data() + begins[i].pyramids);
        parts[i] = {};
    });
    return refused;
}

}  // namespace mortise::improve
