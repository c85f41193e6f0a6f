// A .vtu written from parts: the same bytes as from the whole mesh.
#include <algorithm>
#include <optional>
#include <string>

#include "host/common/lower_case.hpp"
#include "host/io/block_spool.hpp"
#include "host/io/coordinates.hpp"
#include "host/io/element_table.hpp"
#include "host/io/formats.hpp"
#include "host/io/vtu_layout.hpp"
#include "mortise/error.hpp"
#include "mortise/io.hpp"

namespace mortise {
namespace {

using io::SpooledArray;

std::vector<std::uint64_t> scaled(const std::array<std::uint64_t, kElementTypes + 1>& runs,
                                  std::size_t bytes) {
    std::vector<std::uint64_t> result(runs.begin(), runs.end());
    for (std::uint64_t& begin : result) begin *= bytes;
    return result;
}

io::ArrayWriter joined(SpooledArray& array) {
    return [&array](io::TemporaryFile& file) { array.write(file); };
}

}  // namespace

struct MeshFileStream::Implementation {
    Implementation(const std::string& path, const MeshFileOptions& options)
        : name(path), spool(path), packing(io::packing_of(options)), scale(options.scale) {
        file.emplace(path);
    }

    /// Calls come as begin, add, ..., add, commit.
    enum class State { kNew, kBegun, kEnded };
    void expect(State wanted, const char* call) {
        if (state == wanted) return;
        static constexpr const char* kFound[] = {"before begin()", "after begin()", "after the end"};
        refuse(std::string(call) + " was called " + kFound[static_cast<std::size_t>(state)] +
               "; call begin() once, add() for each part, then commit() once");
    }

    /// Ends the stream; its file goes first, since nobody may catch this.
    [[noreturn]] void refuse(const std::string& cause) {
        file.reset();
        state = State::kEnded;
        throw Error(ExitCode::kUsage, "'" + name + "': " + cause);
    }

    /// Whether a part fits into what begin() was told, and its arrays into each other.
    void count(const Mesh& part, const std::vector<float>& scaled_jacobians) {
        bool fits = scaled_jacobians.size() == part.element_count() &&
                    part.points.size() == 3 * part.node_count() &&
                    part.model_dimension.size() == part.node_count();
        added.nodes += part.node_count();
        fits = fits && added.nodes <= totals.nodes;
        for (std::size_t t = 0; t < kElementTypes; ++t) {
            const ElementBlock& block = part.elements[t];
            added.elements[t] += block.size();
            fits = fits && block.nodes.size() == block.size() * io::nodes_per_element(t) &&
                   block.kind.size() == block.size() && added.elements[t] <= totals.elements[t];
        }
        if (!fits) refuse("a part has arrays of unequal length, or more than begin() was told of");
    }

    /// What is known once the totals are.
    struct Arrays {
        Arrays(io::Spool& spool, const MeshTotals& totals, io::Packing packing)
            : runs(totals, false),
              points(spool, {0, 3 * sizeof(double) * totals.nodes}, packing),
              model_dimension(spool, {0, totals.nodes}, packing),
              connectivity(spool, scaled(runs.nodes, io::index_bytes(totals, false)), packing),
              region(spool, scaled(runs.elements, sizeof(std::int32_t)), packing),
              kind(spool, scaled(runs.elements, 1), packing),
              scaled_jacobian(spool, scaled(runs.elements, sizeof(float)), packing) {}

        io::TypeRuns runs;
        SpooledArray points, model_dimension, connectivity, region, kind, scaled_jacobian;
    };

    template <class Index>
    void add_connectivity(std::size_t t, const ElementBlock& block) {
        arrays->connectivity.add(
            t, block.nodes.size() * sizeof(Index),
            io::value_source<Index>([&block, t](std::size_t first, std::size_t last, Index* out) {
                io::vtk_connectivity(block, t, first, last, out);
            }));
    }

    std::string name;
    State state = State::kNew;
    std::optional<io::TemporaryFile> file;
    io::Spool spool;
    io::Packing packing;
    double scale;
    MeshTotals totals, added;
    Mesh outline;
    std::optional<Arrays> arrays;
};

MeshFileStream::MeshFileStream(const std::string& path, const MeshFileOptions& options) {
    check_writable(path);
    io::check_scale(options.scale, path);
    constexpr const char* kExtension = ".vtu";
    const std::size_t length = std::string(kExtension).size();
    if (path.size() < length || lower_case(path.substr(path.size() - length)) != kExtension) {
        throw Error(ExitCode::kUsage,
                    "'" + path + "': a mesh in parts (--memory) can be written as .vtu only");
    }
    implementation_ = std::make_unique<Implementation>(path, options);
}

MeshFileStream::~MeshFileStream() = default;

void MeshFileStream::begin(const MeshTotals& totals, const Mesh& outline) {
    implementation_->expect(Implementation::State::kNew, "begin()");
    implementation_->state = Implementation::State::kBegun;
    implementation_->totals = totals;
    implementation_->outline = outline;
    implementation_->arrays.emplace(implementation_->spool, totals, implementation_->packing);
}

void MeshFileStream::add(const Mesh& part, const std::vector<float>& scaled_jacobians) {
    implementation_->expect(Implementation::State::kBegun, "add()");
    implementation_->count(part, scaled_jacobians);
    Implementation::Arrays& arrays = *implementation_->arrays;
    const bool is_wide = io::index_bytes(implementation_->totals, false) == sizeof(std::int64_t);
    arrays.points.add(0, part.points.size() * sizeof(double),
                      io::Coordinates(part.points, implementation_->scale).source());
    arrays.model_dimension.add(0, part.model_dimension.size(),
                               io::memory_source(part.model_dimension.data()));
    const float* jacobian = scaled_jacobians.data();
    for (std::size_t t = 0; t < kElementTypes; ++t) {
        const ElementBlock& block = part.elements[t];
        if (is_wide) {
            implementation_->add_connectivity<std::int64_t>(t, block);
        } else {
            implementation_->add_connectivity<std::int32_t>(t, block);
        }
        arrays.region.add(
            t, block.size() * sizeof(std::int32_t),
            io::value_source<std::int32_t>([&block](std::size_t first, std::size_t last, std::int32_t* out) {
                std::copy(block.region.data() + first, block.region.data() + last, out);
            }));
        arrays.kind.add(t, block.size(), io::memory_source(block.kind.data()));
        arrays.scaled_jacobian.add(t, block.size() * sizeof(float), io::memory_source(jacobian));
        jacobian += block.size();
    }
}

void MeshFileStream::commit() {
    Implementation& all = *implementation_;
    all.expect(Implementation::State::kBegun, "commit()");
    if (all.added.nodes != all.totals.nodes || all.added.elements != all.totals.elements)
        all.refuse("commit() was called before all nodes and elements that begin() was told of");
    all.state = Implementation::State::kEnded;
    io::VtuArrays arrays;
    arrays.points = joined(all.arrays->points);
    arrays.model_dimension = joined(all.arrays->model_dimension);
    arrays.connectivity = joined(all.arrays->connectivity);
    arrays.region = joined(all.arrays->region);
    arrays.kind = joined(all.arrays->kind);
    arrays.scaled_jacobian = joined(all.arrays->scaled_jacobian);
    io::write_vtu_file(all.totals, all.outline, arrays, all.packing, *all.file);
    all.file->commit();
}

}  // namespace mortise
