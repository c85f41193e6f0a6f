// The way from a model to a file, stage by stage, with each kernel's time.
//
// The same calls in the same order as Mesher::generate (host/pipeline/mesher.cpp) with default options, but
// on a device whose times can be asked for.
#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <initializer_list>

#include "bench/models.hpp"
#include "bench/process.hpp"
#include "bench/stage_bytes.hpp"
#include "bench/workers.hpp"
#include "host/assembly/assembly.hpp"
#include "host/cnio/extract.hpp"
#include "host/improve/improve.hpp"
#include "host/pipeline/names.hpp"
#include "host/pipeline/prepare.hpp"
#include "host/reposition/reposition.hpp"
#include "mortise/check.hpp"
#include "mortise/io.hpp"

namespace mortise::bench {
namespace {

using nlohmann::json;
using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point begin) {
    return std::chrono::duration<double>(Clock::now() - begin).count();
}

double kernel_seconds(const std::vector<device::KernelTime>& times,
                      std::initializer_list<const char*> entries) {
    double sum = 0;
    for (const device::KernelTime& time : times) {
        for (const char* entry : entries) sum += time.entry == entry ? time.seconds : 0;
    }
    return sum;
}

json kernels_json(const std::vector<device::KernelTime>& times) {
    json list = json::array();
    for (const device::KernelTime& time : times) {
        list.push_back({{"kernel", time.entry},
                        {"seconds", time.seconds},
                        {"launches", time.launches},
                        {"items", time.items}});
    }
    return list;
}

struct WrittenFile {
    double bytes = 0, seconds = 0;
    double plain_seconds = 0;  ///< of a plain write of its bytes to a new file
    json figures() const {
        return {{"bytes", bytes}, {"seconds", seconds}, {"plain_write_seconds", plain_seconds}};
    }
};

/// The best of three for both, in turn: pages that a virtual machine has never used cost more than the
/// writing.
WrittenFile write_file(const Mesh& mesh, const std::vector<float>& jacobians, bool compress,
                       const std::filesystem::path& folder) {
    WrittenFile result;
    const std::filesystem::path path = folder / "mesh.vtu", plain = folder / "plain";
    MeshFileOptions options;
    options.compress = compress;
    std::vector<char> content;
    for (int again = 0; again < 3; ++again) {
        auto begin = Clock::now();
        write_mesh(mesh, path.string(), jacobians, options);
        const double seconds = seconds_since(begin);
        content.resize(std::filesystem::file_size(path), 1);
        std::filesystem::remove(path);
        begin = Clock::now();
        std::ofstream(plain, std::ios::binary)
            .write(content.data(), static_cast<std::streamsize>(content.size()))
            .flush();
        const double plain_seconds = seconds_since(begin);
        std::filesystem::remove(plain);
        result.seconds = again == 0 ? seconds : std::min(result.seconds, seconds);
        result.plain_seconds = again == 0 ? plain_seconds : std::min(result.plain_seconds, plain_seconds);
    }
    result.bytes = static_cast<double>(content.size());
    return result;
}

json measure_run(const Model& model, const MeshOptions& options, device::Device& device,
                 const ScratchFolder& folder, json& result) {
    MeshReport report;
    pipeline::Stages stages(options, report);
    device.reset_times();
    const auto begin = Clock::now();
    pipeline::Prepared prepared =
        pipeline::prepare([&device]() -> device::Device& { return device; }, model, options, stages, report);
    const std::vector<device::KernelTime> early = device.times();
    device.reset_times();

    // Once more, for its own time: most complex cells were meshed to find vertices that snap, and are kept.
    const auto extraction_begin = Clock::now();
    const cnio::Extraction extraction = cnio::extract(
        prepared.bound, prepared.tree, prepared.classification.cnio, prepared.apexes, options.threads);
    const double extraction_seconds = seconds_since(extraction_begin);

    const auto assembly_begin = Clock::now();
    const octree::InRegions in_regions(prepared.tree);
    std::vector<assembly::Piece> pieces;
    pieces.push_back(
        assembly::assemble(device, {prepared.bound, prepared.tree, prepared.on_device,
                                    prepared.classification, extraction, in_regions, options.threads}));
    const Mesh before = assembly::merge(std::move(pieces), options.threads);
    const double assembly_seconds = seconds_since(assembly_begin);
    const std::vector<device::KernelTime> late = device.times();

    reposition::Options reposition_options;
    reposition_options.level = prepared.tree.level;
    reposition_options.rounds = 2 * options.smooth;
    reposition_options.threads = options.threads;
    reposition_options.leaves = &prepared.leaves;
    improve::Options improve_options;
    improve_options.level = prepared.tree.level;
    improve_options.smooth = options.smooth;
    improve_options.threads = options.threads;
    improve_options.leaves = &prepared.leaves;
    Mesh copy = before;  // the model of bytes wants both
    const auto improve_begin = Clock::now();
    reposition::reposition(device, prepared.bound, reposition_options, copy);
    improve::Counters counters;
    Mesh mesh = improve::improve(std::move(copy), prepared.bound, improve_options, &counters);
    const double improve_seconds = seconds_since(improve_begin);
    const double seconds =
        std::chrono::duration<double>(extraction_begin - begin).count() + assembly_seconds + improve_seconds;

    mesh.region_names = prepared.compiled.region_names;
    pipeline::name_surfaces(prepared.compiled, prepared.bound, 0, mesh);
    const std::vector<float> jacobians = scaled_jacobians(mesh);
    const WrittenFile file = write_file(mesh, jacobians, true, folder.path());
    const WrittenFile plain_arrays = write_file(mesh, jacobians, false, folder.path());

    const StageBytes bytes = stage_bytes(prepared.tree, extraction, before, mesh, counters.zone_elements);
    const double numbering = kernel_seconds(late, {"own_nodes"});
    const double late_scans = kernel_seconds(late, {"scan_sums", "scan_fill"});
    const double writes = kernel_seconds(late, {"write_templates"});
    json list = json::array();
    const auto add = [&list](const char* stage, double time, double moved) {
        list.push_back({{"stage", stage}, {"seconds", time}, {"bytes", moved}});
    };
    add("descent", kernel_seconds(early, {"descend", "gather_children"}), bytes.descent);
    add("entities",
        kernel_seconds(early, {"classify", "find_points", "share_points", "leave_to_certificate",
                               "find_misfits", "drop_misfits", "classify_snapped", "snap_corners_of",
                               "mark_vertices", "mark_exposed", "test_subsets", "veto_needs"}),
        bytes.entities);
    add("compaction",
        kernel_seconds(early, {"scan_sums", "scan_fill", "mark_in", "mark_nio", "count_word", "promote_words",
                               "promote_leaves"}) +
            late_scans,
        bytes.compaction);
    add("numbering", numbering, bytes.numbering);
    add("templates", kernel_seconds(early, {"fill"}) + writes, bytes.templates);
    add("extraction", extraction_seconds, bytes.extraction);
    add("assembly", assembly_seconds - numbering - late_scans - writes, bytes.assembly);
    add("repositioning", improve_seconds, bytes.repositioning);
    add("writing", file.seconds, mesh_bytes(mesh) + file.bytes);
    result["elements"] = mesh.element_count();
    result["nodes"] = mesh.node_count();
    result["kernels"] = {{"before_extraction", kernels_json(early)}, {"assembly", kernels_json(late)}};
    return {{"seconds", seconds},
            {"files", {{"compressed", file.figures()}, {"plain_arrays", plain_arrays.figures()}}},
            {"stages", list}};
}

}  // namespace

json measure_stages(const Task& task) {
    const Model model = make_model(task.model);
    device::Device device;
    MeshOptions options;
    options.threads = task.threads;
    const ScratchFolder folder;
    json result;
    options.level = std::min(task.level, 3);
    measure_run(model, options, device, folder, result);  // loads the kernels
    options.level = task.level;
    result["device"] = device.info().name;
    result["runs"] = json::array();
    for (int run = 0; run < task.repeats; ++run)
        result["runs"].push_back(measure_run(model, options, device, folder, result));
    return result;
}

}  // namespace mortise::bench
