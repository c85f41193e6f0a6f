// Matches facets: those of all elements with each other, and with the mesh's facet list.
//
// Every facet, of an element or listed, becomes a 20-byte entry filed under its smallest node: a counting
// sort with atomic cursors, two parallel passes over the elements. The entries of one node (a dozen or two)
// are then sorted by their other nodes, which brings equal facets together and makes the order independent of
// the threads. Entries of one facet are judged together by check_group. A face with a hanging node counts as
// a flat element between the larger face and the four that it meets, numbered after all others.
#include <algorithm>
#include <atomic>
#include <limits>
#include <memory>

#include "host/common/parallel.hpp"
#include "host/quality/passes.hpp"

namespace mortise::quality {
namespace {

constexpr std::size_t kElementChunk = 16384;
constexpr std::size_t kNodeChunk = 16384;
constexpr NodeId kNone = std::numeric_limits<NodeId>::max();

/// A facet without its smallest node.
struct Entry {
    NodeId b, c, d;         ///< the other nodes in ascending order; d = kNone for a triangle
    std::uint32_t owner;    ///< element in mesh order, or index in the facet list
    std::uint8_t face;      ///< local face of the element; 0 if listed
    std::uint8_t opposite;  ///< quadrilateral: rank of the node across from the smallest, among b, c, d
    bool reversed;          ///< which way round the nodes run
    bool listed;

    bool same_facet(const Entry& other) const { return b == other.b && c == other.c && d == other.d; }
};
static_assert(sizeof(Entry) == 20, "the memory need stated in check.hpp");

bool operator<(const Entry& left, const Entry& right) {
    if (left.b != right.b) return left.b < right.b;
    if (left.c != right.c) return left.c < right.c;
    if (left.d != right.d) return left.d < right.d;
    if (left.listed != right.listed) return right.listed;
    if (left.owner != right.owner) return left.owner < right.owner;
    return left.face < right.face;
}

/// The entry of a facet with `count` (3 or 4) nodes in cyclic order; returns its smallest node.
NodeId make_entry(const NodeId* nodes, int count, Entry& entry) {
    int start = 0;
    for (int i = 1; i < count; ++i) {
        if (nodes[i] < nodes[start]) start = i;
    }
    const auto next = [&](int step) { return nodes[(start + step) % count]; };
    const NodeId x = next(1), last = next(count - 1);
    entry.reversed = x > last;
    entry.b = std::min(x, last);
    entry.c = std::max(x, last);
    entry.d = kNone;
    entry.opposite = 0;
    if (count == 4) {
        const NodeId across = next(2);
        entry.opposite = static_cast<std::uint8_t>((across > entry.b) + (across > entry.c));
        if (entry.opposite == 2) {
            entry.d = across;
        } else {
            entry.d = entry.c;
            entry.c = entry.opposite == 1 ? across : entry.b;
            if (entry.opposite == 0) entry.b = across;
        }
    }
    return nodes[start];
}

/// Where an element number of the whole mesh lies.
struct Place {
    ElementType type;
    std::size_t index;
};

class FacetMatcher {
  public:
    FacetMatcher(const Mesh& mesh, const std::vector<HangingFace>& hanging, int threads, DefectLog& log,
                 CheckReport& report)
        : mesh_(mesh), hanging_(hanging), threads_(threads), log_(log), report_(report) {
        for (std::size_t t = 0; t < kElementTypes; ++t) first_[t + 1] = first_[t] + mesh.elements[t].size();
    }

    std::vector<BoundaryFacet> run() {
        file_entries();
        const std::size_t owners = first_[kElementTypes] + hanging_.size();
        parents_.reset(new std::atomic<std::uint32_t>[owners]);
        for (std::size_t i = 0; i < owners; ++i) parents_[i] = static_cast<std::uint32_t>(i);
        hanging_region_.reset(new std::atomic<std::uint16_t>[hanging_.size()]());
        const std::size_t nodes = mesh_.node_count();
        std::vector<ChunkResult> results(chunk_count(nodes, kNodeChunk));
        parallel_numbered(nodes, kNodeChunk, threads_,
                          [&](std::size_t chunk, std::size_t begin, std::size_t end) {
                              for (std::size_t node = begin; node < end; ++node)
                                  check_node(node, results[chunk]);
                          });
        std::vector<BoundaryFacet> boundary;
        for (ChunkResult& result : results) {
            log_.merge(result.log);
            boundary.insert(boundary.end(), result.boundary.begin(), result.boundary.end());
            report_.interface_facets += result.interface_facets;
            result = {};
        }
        report_.boundary_facets = boundary.size();
        for (std::size_t i = 0; i < first_[kElementTypes]; ++i) report_.components += parents_[i] == i;
        return boundary;
    }

  private:
    struct ChunkResult {
        DefectLog log;
        std::vector<BoundaryFacet> boundary;
        std::uint64_t interface_facets = 0;
    };

    Place place(std::uint32_t element) const {
        std::size_t type = 0;
        while (element >= first_[type + 1]) ++type;
        return {static_cast<ElementType>(type), element - first_[type]};
    }

    const NodeId* element_nodes(const Place& at) const {
        const std::size_t count = static_cast<std::size_t>(kElementNodes[static_cast<std::size_t>(at.type)]);
        return mesh_.block(at.type).nodes.data() + count * at.index;
    }

    std::uint16_t region(const Entry& entry) const {
        const Place at = place(entry.owner);
        return mesh_.block(at.type).region[at.index];
    }

    bool is_hanging(const Entry& entry) const {
        return !entry.listed && entry.owner >= first_[kElementTypes];
    }

    /// Calls visit(smallest node, entry) for every facet of every element, of flat ones and of the list.
    template <class Visit>
    void visit_facets(const Visit& visit) const {
        for (std::size_t t = 0; t < kElementTypes; ++t) {
            const ElementType type = static_cast<ElementType>(t);
            const LocalFaces faces = local_faces(type);
            parallel_chunks(mesh_.block(type).size(), kElementChunk, threads_,
                            [&](std::size_t i, std::size_t end, int) {
                                for (; i < end; ++i) {
                                    const NodeId* nodes = element_nodes({type, i});
                                    for (int f = 0; f < faces.count; ++f) {
                                        const LocalFace& face = faces.faces[f];
                                        const int count = static_cast<int>(corner_count(face));
                                        NodeId facet[4];
                                        for (int k = 0; k < count; ++k)
                                            facet[k] = nodes[face[static_cast<std::size_t>(k)]];
                                        Entry entry;
                                        const NodeId smallest = make_entry(facet, count, entry);
                                        entry.owner = static_cast<std::uint32_t>(first_[t] + i);
                                        entry.face = static_cast<std::uint8_t>(f);
                                        entry.listed = false;
                                        visit(smallest, entry);
                                    }
                                }
                            });
        }
        for (std::size_t i = 0; i < hanging_.size(); ++i) {
            std::array<NodeId, 4> whole = hanging_[i].whole;
            std::reverse(whole.begin(), whole.end());
            for (std::size_t f = 0; f < 5; ++f) {
                Entry entry;
                const NodeId smallest =
                    make_entry(f == 0 ? whole.data() : hanging_[i].quarters[f - 1].data(), 4, entry);
                entry.owner = static_cast<std::uint32_t>(first_[kElementTypes] + i);
                entry.face = static_cast<std::uint8_t>(f);
                entry.listed = false;
                visit(smallest, entry);
            }
        }
        for (std::size_t i = 0; i < mesh_.facets.size(); ++i) {
            const FacetNodes nodes = mesh_.facets.facet(i);
            Entry entry;
            const NodeId smallest = make_entry(nodes.begin(), static_cast<int>(nodes.size()), entry);
            entry.owner = static_cast<std::uint32_t>(i);
            entry.face = 0;
            entry.listed = true;
            visit(smallest, entry);
        }
    }

    /// Fills entries_ and ends_: the entries of node v are [ends_[v - 1], ends_[v]).
    void file_entries() {
        const std::size_t nodes = mesh_.node_count();
        ends_.reset(new std::atomic<std::uint64_t>[nodes]());
        visit_facets([&](NodeId node, const Entry&) { ends_[node].fetch_add(1, std::memory_order_relaxed); });
        std::uint64_t total = 0;
        for (std::size_t i = 0; i < nodes; ++i) {
            const std::uint64_t count = ends_[i];
            ends_[i].store(total, std::memory_order_relaxed);
            total += count;
        }
        entries_.reset(new Entry[total]);
        visit_facets([&](NodeId node, const Entry& entry) {
            entries_[ends_[node].fetch_add(1, std::memory_order_relaxed)] = entry;
        });
    }

    void check_node(std::size_t node, ChunkResult& result) {
        Entry* begin = entries_.get() + (node == 0 ? 0 : ends_[node - 1].load(std::memory_order_relaxed));
        Entry* const end = entries_.get() + ends_[node].load(std::memory_order_relaxed);
        std::sort(begin, end);
        while (begin != end) {
            Entry* group_end = begin + 1;
            while (group_end != end && group_end->same_facet(*begin)) ++group_end;
            check_group(static_cast<NodeId>(node), begin, group_end, result);
            begin = group_end;
        }
    }

    static std::string text(const Mesh& mesh, NodeId node, const Entry& entry) {
        const NodeId nodes[4] = {node, entry.b, entry.c, entry.d};
        return facet_text(mesh, nodes, entry.d == kNone ? 3 : 4);
    }

    std::string owner_text(const Entry& entry) const {
        if (entry.listed) return "facet " + std::to_string(entry.owner) + " of the list";
        if (is_hanging(entry)) return "hanging face " + std::to_string(entry.owner - first_[kElementTypes]);
        const Place at = place(entry.owner);
        return std::string(element_name(at.type)) + " " + std::to_string(at.index);
    }

    /// All entries of one facet: first those of elements, then listed ones.
    void check_group(NodeId node, const Entry* begin, const Entry* end, ChunkResult& result) {
        const Entry* listed = begin;
        while (listed != end && !listed->listed) ++listed;
        const std::size_t elements = static_cast<std::size_t>(listed - begin);
        const auto report = [&](DefectKind kind, const Entry& entry) {
            result.log.add(kind, [&] { return text(mesh_, node, entry) + ": " + owner_text(entry); });
        };
        for (const Entry* entry = begin + 1; entry < listed; ++entry) {
            join(begin->owner, entry->owner);
            if (!is_hanging(*entry)) check_duplicate(begin, entry, result);
        }
        if (elements > 2) {
            report(DefectKind::kFacetShared, begin[2]);
        } else if (elements == 2) {
            if (begin[0].opposite != begin[1].opposite) {
                report(DefectKind::kFacetQuadrilateralOrder, begin[1]);
            } else if (begin[0].reversed == begin[1].reversed) {
                report(DefectKind::kFacetSameOrientation, begin[1]);
            }
        } else if (elements == 1) {
            if (is_hanging(*begin)) return report(DefectKind::kHangingFace, *begin);
            result.boundary.push_back(boundary_facet(*begin));
        }
        if (elements == 2 && is_hanging(begin[1])) {
            check_hanging_region(begin, report);
            if (listed != end) report(DefectKind::kListedInside, *listed);
            return;
        }
        if (end - listed > 1) report(DefectKind::kListedTwice, listed[1]);
        check_listed(begin, elements, listed == end ? nullptr : listed, report, result);
    }

    /// An element and a flat one: all elements around the latter are of one region.
    template <class Report>
    void check_hanging_region(const Entry* entry, const Report& report) {
        if (is_hanging(entry[0])) return report(DefectKind::kFacetShared, entry[0]);
        const std::uint16_t mine = region(entry[0]);
        std::uint16_t known = 0;
        auto& shared = hanging_region_[entry[1].owner - first_[kElementTypes]];
        if (!shared.compare_exchange_strong(known, mine) && known != mine)
            report(DefectKind::kHangingRegion, entry[0]);
    }

    /// Compares a facet's elements with its entry in the list, null if there is none.
    template <class Report>
    void check_listed(const Entry* owners, std::size_t elements, const Entry* listed, const Report& report,
                      ChunkResult& result) const {
        if (elements == 0) return report(DefectKind::kListedNowhere, *listed);
        if (elements > 2) return;  // reported; there is no right entry to compare with
        const std::uint16_t back = region(owners[0]);
        const std::uint16_t front = elements == 2 ? region(owners[1]) : std::uint16_t{0};
        if (elements == 2 && back == front) {
            if (listed != nullptr) report(DefectKind::kListedInside, *listed);
            return;
        }
        result.interface_facets += elements == 2;
        if (listed == nullptr) {
            report(elements == 1 ? DefectKind::kMissingBoundary : DefectKind::kMissingInterface, owners[0]);
            return;
        }
        const std::uint16_t inside = mesh_.facets.inside[listed->owner];
        const std::uint16_t outside = mesh_.facets.outside[listed->owner];
        const bool as_first = inside == back && outside == front;
        const bool as_second = elements == 2 && inside == front && outside == back;
        if (!as_first && !as_second) return report(DefectKind::kListedRegions, *listed);
        const Entry& owner = owners[as_first ? 0 : 1];
        if (listed->opposite != owner.opposite || listed->reversed != owner.reversed) {
            report(DefectKind::kListedOrientation, *listed);
        }
    }

    /// Duplicates share all their facets; `entry` counts where its face 0 meets an earlier element, that is,
    /// one of the entries from `begin` on.
    void check_duplicate(const Entry* begin, const Entry* entry, ChunkResult& result) const {
        if (entry->face != 0) return;
        for (const Entry* other = begin; other != entry; ++other) {
            if (other->owner == entry->owner || !same_nodes(*other, *entry)) continue;
            const Place at = place(entry->owner);
            result.log.add(DefectKind::kElementDuplicate, [&] {
                return element_text(mesh_, at.type, at.index) + " repeats " + owner_text(*other);
            });
            return;
        }
    }

    bool same_nodes(const Entry& left, const Entry& right) const {
        const Place a = place(left.owner), b = place(right.owner);
        if (a.type != b.type) return false;
        const std::size_t count = static_cast<std::size_t>(kElementNodes[static_cast<std::size_t>(a.type)]);
        return std::is_permutation(element_nodes(a), element_nodes(a) + count, element_nodes(b));
    }

    BoundaryFacet boundary_facet(const Entry& entry) const {
        const Place at = place(entry.owner);
        const NodeId* nodes = element_nodes(at);
        const LocalFace& face = local_faces(at.type).faces[entry.face];
        BoundaryFacet facet;
        for (std::size_t k = 0; k < 4; ++k) facet.nodes[k] = nodes[face[face[k] < 0 ? k - 1 : k]];
        return facet;
    }

    /// Lock-free union-find: a root is only ever hung below a smaller root, so the roots left at the end, one
    /// per component, do not depend on the order of the calls.
    void join(std::uint32_t left, std::uint32_t right) {
        while (true) {
            left = find(left);
            right = find(right);
            if (left == right) return;
            if (left < right) std::swap(left, right);
            std::uint32_t expected = left;
            if (parents_[left].compare_exchange_weak(expected, right)) return;
        }
    }

    std::uint32_t find(std::uint32_t element) {
        while (true) {
            std::uint32_t parent = parents_[element];
            if (parent == element) return element;
            const std::uint32_t grandparent = parents_[parent];
            // Path halving; losing the race to another thread is harmless.
            if (parent != grandparent) parents_[element].compare_exchange_weak(parent, grandparent);
            element = grandparent;
        }
    }

    const Mesh& mesh_;
    const std::vector<HangingFace>& hanging_;
    const int threads_;
    DefectLog& log_;
    CheckReport& report_;
    std::array<std::size_t, kElementTypes + 1> first_{};  ///< number of the first element of each type
    std::unique_ptr<std::atomic<std::uint64_t>[]> ends_;
    std::unique_ptr<Entry[]> entries_;
    std::unique_ptr<std::atomic<std::uint32_t>[]> parents_;
    std::unique_ptr<std::atomic<std::uint16_t>[]> hanging_region_;  ///< of flat elements; 0: not known yet
};

}  // namespace

std::vector<BoundaryFacet> check_facets(const Mesh& mesh, const std::vector<HangingFace>& hanging,
                                        int threads, DefectLog& log, CheckReport& report) {
    return FacetMatcher(mesh, hanging, threads, log, report).run();
}

}  // namespace mortise::quality
