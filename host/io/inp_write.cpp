// Writes .inp: an input deck of Abaqus, as CalculiX reads it: text, nodes and elements numbered from 1.
//
// Each region is an element set, each surface a set of nodes and a surface of element faces (as facets are
// grouped: facet_groups.hpp), all names made of letters, digits and underscores; a comment before each tells
// the name it has in the model. Sets NALL and EALL have everything. Materials, steps and boundary conditions
// are the reader's, in a file with *INCLUDE, INPUT=mesh.inp.
//
// CalculiX has no pyramids: they are bricks whose upper four nodes are one, whose functions on triangles are
// those of the neighbours. Of second order these would differ there, so such pyramids are refused.
//
// Limits of CalculiX: 16 entries a line, 20 characters a number, 80 a name.
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <set>
#include <string>
#include <vector>

#include "host/common/parallel.hpp"
#include "host/common/sort_unique.hpp"
#include "host/io/coordinates.hpp"
#include "host/io/element_table.hpp"
#include "host/io/facet_groups.hpp"
#include "host/io/facet_sides.hpp"
#include "host/io/formats.hpp"

namespace mortise::io {
namespace {

constexpr std::size_t kLineEntries = 16, kNumberLength = 20, kNameLength = 80;
constexpr std::size_t kLines = 4096;  ///< that a thread makes at a time
constexpr std::size_t kWave = 64;     ///< times that, before they are written

struct InpElement {
    const char* first_order;
    const char* second_order;
};
/// In the order of ElementType. Nodes and edges are numbered as ours, also of the pyramid's brick.
constexpr std::array<InpElement, kElementTypes> kInpElements = {
    {{"C3D8", "C3D20"}, {"C3D6", "C3D15"}, {"C3D8", nullptr}, {"C3D4", "C3D10"}}};
constexpr std::size_t kApexRepeats = 3;  ///< of a pyramid, until it is a brick

/// The number of a face in a deck, from 1. Of the brick that is a pyramid, face 2 is a point.
int deck_face(ElementType type, int face) {
    return type == ElementType::kPyramid && face > 0 ? face + 2 : face + 1;
}

void add_number(std::string& text, std::uint64_t value) {
    char digits[24];
    text.append(digits, std::to_chars(digits, digits + sizeof digits, value).ptr);
}

/// The shortest text that reads back as the same number, or 14 digits where that is too long to be read.
void add_coordinate(std::string& text, double value) {
    constexpr int kDigits = 13;  // behind the point: -1.2345678901234e-05 has 20 characters
    char digits[64];
    char* end = std::to_chars(digits, digits + sizeof digits, value).ptr;
    if (end - digits > static_cast<std::ptrdiff_t>(kNumberLength)) {
        const bool is_long = value != 0 && (std::fabs(value) < 1e-99 || std::fabs(value) >= 1e100);
        end = std::to_chars(digits, digits + sizeof digits, value, std::chars_format::scientific,
                            is_long ? kDigits - 1 : kDigits)
                  .ptr;
    }
    text.append(digits, end);
}

/// A list of numbers over as many lines as it needs; lines but the last end in a comma.
class NumberLines {
  public:
    explicit NumberLines(std::string& text) : text_(text) {}
    void add(std::uint64_t value) {
        if (entries_ == kLineEntries) {
            text_ += ",\n";
            entries_ = 0;
        } else if (entries_ > 0) {
            text_ += ", ";
        }
        add_number(text_, value);
        ++entries_;
    }
    void end() { text_ += "\n"; }

  private:
    std::string& text_;
    std::size_t entries_ = 0;
};

/// Names of one kind of set: readers take no difference between small and capital letters.
class DeckNames {
  public:
    explicit DeckNames(const char* reserved) { taken_.insert(reserved); }
    std::string name(const std::string& wanted) {
        std::string word;
        for (const char c : wanted) {
            const bool is_small = c >= 'a' && c <= 'z';
            const bool fits = is_small || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
            word += is_small ? static_cast<char>(c - 'a' + 'A') : fits ? c : '_';
        }
        constexpr std::size_t kNumber = 12;  // what unique_name may add
        if (word.empty() || word[0] < 'A' || word[0] > 'Z') word = "S_" + word;
        return unique_name(word.substr(0, kNameLength - kNumber), taken_);
    }

  private:
    std::set<std::string> taken_;
};

/// What a comment can hold of a name: readers break long lines, and take the rest for data.
std::string quoted(const std::string& name) {
    constexpr std::size_t kMost = 120;
    std::string text = "'";
    for (const char c : name.substr(0, kMost)) text += static_cast<unsigned char>(c) < ' ' ? '_' : c;
    return text + (name.size() > kMost ? "…'" : "'");
}

class InpWriter {
  public:
    InpWriter(const Mesh& mesh, const MeshFileOptions& options, TemporaryFile& file)
        : mesh_(mesh),
          points_(mesh.points, options.scale),
          threads_(options.threads),
          file_(file),
          second_order_(mesh.is_second_order()) {}

    void write() {
        file_.write("** Made by Mortise: " + std::to_string(mesh_.node_count()) + " nodes, " +
                    std::to_string(mesh_.element_count()) + " elements\n");
        write_nodes();
        write_elements();
        write_surfaces();
    }

  private:
    /// Items 0 to count - 1, as add(i, text) puts them into words, in order.
    template <class Add>
    void write_items(std::size_t count, const Add& add) {
        for (std::size_t wave = 0; wave < count; wave += kWave * kLines) {
            const std::size_t size = std::min(count - wave, kWave * kLines);
            texts_.resize(std::max(texts_.size(), chunk_count(size, kLines)));
            parallel_chunks(size, kLines, threads_, [&](std::size_t begin, std::size_t end, int) {
                std::string& text = texts_[begin / kLines];
                text.clear();
                for (std::size_t i = begin; i < end; ++i) add(wave + i, text);
            });
            for (std::size_t i = 0; i < chunk_count(size, kLines); ++i) file_.write(texts_[i]);
        }
    }

    void write_nodes() {
        file_.write("*NODE, NSET=NALL\n");
        write_items(mesh_.node_count(), [&](std::size_t i, std::string& text) {
            add_number(text, i + 1);
            for (std::size_t j = 0; j < 3; ++j) {
                text += ", ";
                add_coordinate(text, points_[3 * i + j]);
            }
            text += "\n";
        });
    }

    void write_elements() {
        DeckNames names("EALL");
        std::vector<std::string> sets;
        for (const std::string& name : mesh_.region_names) {
            sets.push_back(names.name(name));
            file_.write("** region " + quoted(name) + ": " + sets.back() + "\n");
        }
        std::vector<std::uint8_t> is_used(sets.size(), 0);
        std::uint64_t first = 1;
        for (std::size_t t = 0; t < kElementTypes; ++t) {
            const std::vector<std::vector<std::uint32_t>> members = by_region(mesh_.elements[t].region);
            for (std::size_t r = 0; r < sets.size(); ++r) {
                if (members[r].empty()) continue;
                write_block(t, members[r], sets[r], first);
                is_used[r] = 1;
            }
            first += mesh_.elements[t].size();
        }
        file_.write("*ELSET, ELSET=EALL\n");
        for (std::size_t r = 0; r < sets.size(); ++r) {
            if (is_used[r] != 0) file_.write(sets[r] + "\n");
        }
    }

    std::vector<std::vector<std::uint32_t>> by_region(const std::vector<std::uint16_t>& region) const {
        std::vector<std::vector<std::uint32_t>> members(mesh_.region_names.size());
        for (std::size_t i = 0; i < region.size(); ++i)
            members[region[i] - 1u].push_back(static_cast<std::uint32_t>(i));
        return members;
    }

    void write_block(std::size_t t, const std::vector<std::uint32_t>& members, const std::string& set,
                     std::uint64_t first) {
        const ElementBlock& block = mesh_.elements[t];
        const InpElement& element = kInpElements[t];
        file_.write(
            "*ELEMENT, TYPE=" + std::string(second_order_ ? element.second_order : element.first_order) +
            ", ELSET=" + set + "\n");
        const std::size_t corners = nodes_per_element(t);
        const std::size_t middles = second_order_ ? middles_per_element(t) : 0;
        const std::size_t repeats = static_cast<ElementType>(t) == ElementType::kPyramid ? kApexRepeats : 0;
        write_items(members.size(), [&](std::size_t m, std::string& text) {
            const std::size_t i = members[m];
            NumberLines line(text);
            line.add(first + i);
            const NodeId* const node = block.nodes.data() + corners * i;
            for (std::size_t k = 0; k < corners; ++k) line.add(std::uint64_t{node[k]} + 1);
            for (std::size_t k = 0; k < repeats; ++k) line.add(std::uint64_t{node[corners - 1]} + 1);
            const NodeId* const middle = block.middles.data() + middles * i;
            for (std::size_t k = 0; k < middles; ++k) line.add(std::uint64_t{middle[k]} + 1);
            line.end();
        });
    }

    void write_surfaces() {
        const FacetGroups groups = group_facets(mesh_.facets);
        const std::vector<FacetSide> sides = facet_sides(mesh_, threads_);
        std::vector<std::vector<std::uint32_t>> facets(groups.groups.size());
        for (std::size_t f = 0; f < groups.of.size(); ++f)
            facets[groups.of[f]].push_back(static_cast<std::uint32_t>(f));
        DeckNames names("NALL");
        const std::vector<std::string> wanted = group_names(mesh_, groups.groups);
        for (std::size_t g = 0; g < facets.size(); ++g) {
            const std::string name = names.name(wanted[g]);
            file_.write("** surface " + quoted(wanted[g]) + "\n*NSET, NSET=" + name + "\n");
            const std::vector<NodeId> nodes = nodes_of(facets[g]);
            write_items(chunk_count(nodes.size(), kLineEntries), [&](std::size_t i, std::string& text) {
                NumberLines line(text);
                const std::size_t end = std::min(nodes.size(), (i + 1) * kLineEntries);
                for (std::size_t k = i * kLineEntries; k < end; ++k) line.add(std::uint64_t{nodes[k]} + 1);
                line.end();
            });
            file_.write("*SURFACE, NAME=" + name + ", TYPE=ELEMENT\n");
            write_items(facets[g].size(), [&](std::size_t i, std::string& text) {
                const FacetSide& side = sides[facets[g][i]];
                add_number(text, side.element + 1);
                text += ", S";
                add_number(text, static_cast<std::uint64_t>(deck_face(side.type, side.face)));
                text += "\n";
            });
        }
    }

    std::vector<NodeId> nodes_of(const std::vector<std::uint32_t>& facets) const {
        std::vector<NodeId> nodes;
        for (const std::uint32_t f : facets) {
            const FacetNodes corners = mesh_.facets.facet(f);
            nodes.insert(nodes.end(), corners.begin(), corners.end());
            if (second_order_)
                nodes.insert(nodes.end(), mesh_.facets.middles.data() + 4 * std::size_t{f},
                             mesh_.facets.middles.data() + 4 * std::size_t{f} + corners.size());
        }
        sort_unique(nodes);
        return nodes;
    }

    const Mesh& mesh_;
    const Coordinates points_;
    const int threads_;
    TemporaryFile& file_;
    const bool second_order_;
    std::vector<std::string> texts_;  ///< of a wave; kept, as their memory costs more than filling it
};

}  // namespace

void write_inp(const Mesh& mesh, const MeshFileOptions& options, TemporaryFile& file) {
    InpWriter(mesh, options, file).write();
}

}  // namespace mortise::io
