#include "host/pipeline/parts.hpp"

#include <algorithm>

#include "host/pipeline/piece.hpp"

namespace mortise::pipeline {
namespace {

// Bytes that making a part takes for each of its leaves, measured on spheres, brackets and boxes.
constexpr std::uint64_t kInBytes = 170;
constexpr std::uint64_t kSnioBytes = 700;
constexpr std::uint64_t kCnioBytes = 8000;
/// Parts end where whole cubes of 8³ finest cells end: 512 codes.
constexpr std::size_t kWordsPerStep = 16;
/// Numbers have 32 bits, and the last one stands for none.
constexpr std::uint64_t kMost = 0xffffffffu;

}  // namespace

Parts::Parts(device::Device& device, const MeshOptions& options, Prepared& prepared, Stages& stages,
             std::uint64_t bytes, std::size_t count)
    : device_(device), options_(options), prepared_(prepared), stages_(stages), in_regions_(prepared.tree) {
    cut(bytes, count);
}

void Parts::cut(std::uint64_t bytes, std::size_t count) {
    const octree::Octree& tree = prepared_.tree;
    const std::size_t words = tree.words();
    std::vector<std::size_t> ends;
    if (count > 0) {
        for (std::size_t p = 1; p < count; ++p) {
            const std::size_t end = words * p / count;
            if (end > (ends.empty() ? 0 : ends.back())) ends.push_back(end);
        }
    } else {
        const std::vector<std::uint32_t>& cnio = prepared_.classification.cnio;
        const auto cost = [&](std::size_t word) {
            const auto complex = static_cast<std::uint64_t>(
                std::lower_bound(cnio.begin(), cnio.end(), tree.nio_rank[word]) - cnio.begin());
            return kInBytes * tree.in_rank[word] + kSnioBytes * (tree.nio_rank[word] - complex) +
                   kCnioBytes * complex;
        };
        std::uint64_t paid = 0;
        std::size_t last = 0;
        for (std::size_t word = kWordsPerStep; word < words; word += kWordsPerStep) {
            const std::uint64_t due = cost(std::min(word + kWordsPerStep, words));
            if (due - paid <= bytes || word == last) continue;
            ends.push_back(word);
            last = word;
            paid = cost(word);
        }
    }
    ends.push_back(words);
    assembly::MortonRange range;
    for (const std::size_t end : ends) {
        range.end = end == words ? assembly::MortonRange{}.end : tree.code_of_word(end);
        ranges_.push_back(range);
        range.begin = range.end;
    }
}

Part Parts::make(std::size_t p, double progress, double next) {
    const bool is_new = p == known_.size();
    Extracted ignored;
    assembly::Piece piece = make_piece(device_, options_, prepared_, in_regions_, ranges_[p], stages_,
                                       progress, next, is_new ? extracted_ : ignored);
    if (is_new) learn(p, piece);
    Part part;
    part.mesh = std::move(piece.mesh);
    part.own = part.mesh.node_count();
    part.first = known_[p].first;
    part.first_element = known_[p].first_element;
    part.is_shared.assign(part.own, 0);
    for (const auto& entry : piece.grid_frontier) part.is_shared[entry.second] = 1;
    for (const auto& entry : piece.extra_frontier) part.is_shared[entry.second] = 1;
    resolve(piece.foreign_grid, grid_, part);
    resolve(piece.foreign_extras, extras_, part);
    add_foreign_points(piece, part);
    if (is_new) known_[p].foreign = part.foreign;
    return part;
}

/// Numbers the nodes and elements of a part that is made for the first time, and keeps what later ones need.
void Parts::learn(std::size_t p, const assembly::Piece& piece) {
    const Mesh& mesh = piece.mesh;
    const std::uint64_t end = totals_.nodes + mesh.node_count();
    bool is_too_large = end >= kMost;
    for (std::size_t t = 0; t < kElementTypes; ++t)
        is_too_large = is_too_large || totals_.elements[t] + mesh.elements[t].size() >= kMost;
    if (is_too_large)
        throw Error(ExitCode::kMeshing, "more than 2^32 nodes, or elements of a type; use a lower --level");
    known_.push_back({static_cast<NodeId>(totals_.nodes), static_cast<NodeId>(end), totals_.elements, {}});
    if (p + 1 < ranges_.size()) {
        const auto point_of = [&mesh](NodeId local) {
            const double* point = mesh.points.data() + 3 * std::size_t{local};
            return Point{point[0], point[1], point[2]};
        };
        for (const auto& [name, local] : piece.grid_frontier) {
            grid_.push_back({name, known_[p].first + local});
            if (point_of(local) != grid_point(name)) moved_.push_back({name, point_of(local)});
        }
        for (const auto& [name, local] : piece.extra_frontier) {
            extras_.push_back({name, known_[p].first + local});
            extra_points_.push_back(point_of(local));
        }
    }
    totals_.nodes = end;
    for (std::size_t t = 0; t < kElementTypes; ++t) totals_.elements[t] += mesh.elements[t].size();
}

template <class Name>
void Parts::resolve(const std::vector<Name>& names, const std::deque<Shared<Name>>& shared, Part& part) {
    auto at = shared.begin();
    for (const Name& name : names) {
        at = std::lower_bound(at, shared.end(), name);
        if (at == shared.end() || name < at->name) {
            throw Error(ExitCode::kMeshing,
                        "internal error: a node of another part is missing; please report the model");
        }
        part.foreign.push_back(at->number);
    }
}

void Parts::add_foreign_points(const assembly::Piece& piece, Part& part) const {
    std::vector<double>& points = part.mesh.points;
    const auto add = [&points](const Point& point) {
        points.insert(points.end(), point.begin(), point.end());
    };
    auto moved = moved_.begin();
    for (const std::uint64_t name : piece.foreign_grid) {
        moved = std::lower_bound(moved, moved_.end(), name, [](const auto& entry, std::uint64_t wanted) {
            return entry.first < wanted;
        });
        add(moved != moved_.end() && moved->first == name ? moved->second : grid_point(name));
    }
    for (const assembly::ExtraName& name : piece.foreign_extras)
        add(extra_points_[static_cast<std::size_t>(std::lower_bound(extras_.begin(), extras_.end(), name) -
                                                   extras_.begin())]);
}

/// As place_nodes puts it (kernels/assembly/number.cl).
Parts::Point Parts::grid_point(std::uint64_t name) const {
    const std::uint64_t owner = name >> kNodeBits;
    const auto corner = static_cast<u32>(name & ((1u << kNodeBits) - 1));
    const double cell = prepared_.tree.finest_edge();
    Point point;
    for (u32 j = 0; j < 3; ++j) {
        const double local = (gather_bits(owner >> j) + (corner < 8 ? (corner >> j) & 1 : 0)) * cell;
        point[j] = model_coordinate(prepared_.bound.origin[j], prepared_.bound.side, local);
    }
    return point;
}

}  // namespace mortise::pipeline
