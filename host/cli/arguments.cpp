// The command line as data, by CLI11. Numbers are parsed here, so that every message names option and value.
#include "host/cli/arguments.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "host/cli/files.hpp"
#include "host/cli/help_formatter.hpp"
#include "host/common/lower_case.hpp"

namespace mortise::cli {
namespace {

constexpr const char* kExamples = R"(
Examples: mortise bracket.csg -o bracket.vtu --picture bracket.png
          mortise pipe.geo -o pipe.vtu -o pipe.msh --box -1 -1 0 1 1 4 --size 0.05
)";

constexpr const char* kExitCodes = R"(Exit codes:
  0 success                       4 quality floor not met (mesh is written)
  1 wrong usage                   5 no OpenCL device, kernel build, memory
  2 model not understood, empty   6 file not found, not readable or writable
  3 no valid mesh; --strict       130, 143 interrupted (SIGINT, SIGTERM)
)";

[[noreturn]] void refuse(const std::string& message) { throw Error(ExitCode::kUsage, message); }

double parse_number(const std::string& option, const std::string& text) {
    char* end = nullptr;
    const double value = std::strtod(text.c_str(), &end);
    if (text.empty() || *end != '\0' || !std::isfinite(value)) {
        refuse(option + " '" + text + "': expected a finite number");
    }
    return value;
}

int parse_integer(const std::string& option, const std::string& text, int smallest, const char* hint) {
    char* end = nullptr;
    errno = 0;
    const long value = std::strtol(text.c_str(), &end, 10);
    if (text.empty() || *end != '\0' || errno == ERANGE || value < smallest ||
        value > std::numeric_limits<int>::max()) {
        refuse(option + " '" + text + "': expected a whole number from " + std::to_string(smallest) + hint);
    }
    return static_cast<int>(value);
}

/// The words as CLI11 leaves them.
struct Words {
    std::string level, size, elements, extrude, floor, threads, work_group, facets, jobs;
    std::string memory;
    std::string refine, curvature, size_min, size_max, coarsening;
    std::vector<std::string> box, size_at, size_of;
    bool no_model_sizes = false;
    bool box_fit = false;
    bool no_templates = false;
    bool no_snap = false;
    bool hanging = false;
    bool no_improve = false;
    bool no_compress = false;
    std::string smooth, min_angle, merge;
};

/// An empty word, as from an unset shell variable, is a mistake.
void refuse_empty_values(CLI::App& app) {
    for (CLI::Option* option : app.get_options()) {
        if (option->get_type_size() == 0) continue;
        option->check([](const std::string& value) {
            return std::string(value.empty() ? "expected a value, found an empty word" : "");
        });
    }
}

void add_define(CLI::App& app, Arguments& arguments) {
    app.add_option("-D,--define", arguments.read.definitions, "NAME=VALUE: a variable of .scad (repeatable)")
        ->option_text("DEFINITION")
        ->allow_extra_args(false);
}

void add_facets(CLI::App& app, Words& words) {
    app.add_option("--facets", words.facets,
                   "circles of .csg, .scad: smooth (default), or exact as OpenSCAD's")
        ->option_text("smooth|exact");
}

/// How the file is understood.
void add_shape_options(CLI::App& app, Arguments& arguments, Words& words) {
    add_define(app, arguments);
    app.add_option("--box", words.box, "X0 Y0 Z0 X1 Y1 Z1: cut the solid there; required if it is infinite")
        ->option_text("CORNERS")
        ->type_size(6)
        ->expected(1)
        ->multi_option_policy(CLI::MultiOptionPolicy::Throw);
    app.add_option("--extrude", words.extrude, "solid of height H above a function of x and y (.vm, .frep)")
        ->option_text("H");
    add_facets(app, words);
}

void add_model_options(CLI::App& app, Arguments& arguments, Words& words) {
    app.add_option("MODEL", arguments.file,
                   "model file: .csg, .scad, .geo, .stl, .obj, .off, .formula, .vm or .frep");
    app.add_option("-o,--output", arguments.outputs,
                   ".vtu, .msh, or OpenFOAM's folder polyMesh; may be given several times")
        ->option_text("FILE")
        ->allow_extra_args(false);
    add_shape_options(app, arguments, words);
}
void add_size_options(CLI::App& app, Arguments& arguments, Words& words) {
    app.option_defaults()->group("Sizes of cells");
    CLI::Option* level =
        app.add_option("--level", words.level, "split the root cube LEVEL times: 1 to 10, default 6")
            ->option_text("LEVEL");
    app.add_option("--size", words.size, "edge length of a cell in model units, instead of --level")
        ->option_text("LENGTH")
        ->excludes(level);
    CLI::Option* refine =
        app.add_option("--refine", words.refine, "cells up to N levels smaller at thin walls, gaps, holes")
            ->option_text("N");
    app.add_option("--curvature-elements", words.curvature,
                   "and where a full turn of a surface has less than N cells")
        ->option_text("N")
        ->needs(refine);
    app.add_option("--size-of", words.size_of,
                   "NAME H: at most H in that region, or on that surface (repeatable)")
        ->option_text("SIZE")
        ->type_size(2)
        ->expected(-1);
    app.add_option("--size-at", words.size_at, "X Y Z H G: at most H + G times the distance (repeatable)")
        ->option_text("SIZE")
        ->type_size(5)
        ->expected(-1);
    app.add_option("--size-formula", arguments.options.size_formula, "at most F, a formula in x, y, z")
        ->option_text("F");
    app.add_option("--size-max", words.size_max, "no cell larger than this, inside neither")
        ->option_text("LENGTH");
    app.add_option("--size-min", words.size_min,
                   "nothing that asks for small cells makes them smaller than this")
        ->option_text("LENGTH");
    app.add_flag("--no-model-sizes", words.no_model_sizes, "ignore element sizes in the file (-maxh)");
    app.add_option("--interior-coarsening", words.coarsening, "cells inside up to N levels larger")
        ->option_text("N");
    app.add_flag("--box-fit", words.box_fit, "place the grid so that faces of the model lie on its planes");
}

void add_element_options(CLI::App& app, Arguments& arguments, Words& words) {
    app.option_defaults()->group("Elements");
    app.add_option("--elements", words.elements, "hex: mostly hexahedra (default); tet: tetrahedra only")
        ->option_text("hex|tet");
    app.add_flag("--hanging", words.hanging,
                 "cells inside beside smaller ones stay hexahedra, with hanging nodes");
    app.add_option("--min-angle", words.min_angle, "smallest dihedral angle that elements get, 18 to 35 (18)")
        ->option_text("ANGLE");
    app.add_option("--smooth", words.smooth, "rounds of moving nodes to better places, 0 to 100 (4)")
        ->option_text("ROUNDS");
    app.add_option("--merge", words.merge,
                   "instead of slivers, nodes may merge within X cells, or move 3 X (0.05)")
        ->option_text("X");
    app.add_flag("--no-improve", words.no_improve, "leave elements as templates and certificate make them");
    app.add_flag("--no-snap", words.no_snap, "do not move grid vertices onto the surface");
    app.add_flag("--no-templates", words.no_templates, "mesh simple surface cells like complex ones");
    app.add_flag("--strict", arguments.options.strict,
                 "exit 3, write nothing, if a feature may be missing or regions overlap");
    app.add_option("--quality-floor", words.floor, "exit 4 if a scaled Jacobian is below X, 0 to 1")
        ->option_text("X");
}

void add_device_options(CLI::App& app, Arguments& arguments, Words& words) {
    app.add_option("--device", arguments.options.device, "number or part of a name from `mortise devices`")
        ->option_text("DEVICE");
    app.add_option("--threads", words.threads, "host threads, default all cores")->option_text("COUNT");
    app.add_option("--work-group", words.work_group, "OpenCL work-group size, default by device")
        ->option_text("COUNT");
}

void add_file_options(CLI::App& app, Words& words) {
    app.add_flag("--no-compress", words.no_compress,
                 "plain arrays in .vtu: written faster, 4 times as large");
}

void add_output_options(CLI::App& app, Arguments& arguments, Words& words) {
    app.option_defaults()->group("Reports and running");
    app.add_flag("--check", arguments.check, "validate the mesh first; write nothing if it has defects");
    app.add_flag("--quality", arguments.quality, "report shapes, distance to the model, features");
    app.add_option("--features", arguments.features, "write creases and corners, .vtp")->option_text("FILE");
    app.add_option("--picture", arguments.picture, "draw the mesh, .png")->option_text("FILE");
    app.add_option("--report", arguments.report, "write figures and times, .json")->option_text("FILE");
    CLI::Option* json = app.add_flag("--json", arguments.json, "print the report on stdout, not the summary");
    app.add_flag("--quiet", arguments.quiet, "no summary and no progress; warnings stay")->excludes(json);
    add_device_options(app, arguments, words);
    app.add_option("--memory", words.memory, "mesh part by part within this much memory: 4G, 800M (.vtu)")
        ->option_text("BYTES");
    add_file_options(app, words);
}

void add_mesh_options(CLI::App& app, Arguments& arguments, Words& words) {
    app.set_version_flag("--version", "mortise " MORTISE_VERSION, "print the version");
    add_model_options(app, arguments, words);
    add_size_options(app, arguments, words);
    add_element_options(app, arguments, words);
    add_output_options(app, arguments, words);
    refuse_empty_values(app);
    app.footer(std::string(kExamples) + kExitCodes);
}

CLI::App* add_command(CLI::App& app, const char* name, const char* usage, const char* description) {
    CLI::App* command = app.add_subcommand(name, description);
    command->formatter(std::make_shared<HelpFormatter>(usage));
    command->set_help_flag("-h,--help", "print this help");
    command->footer(kExitCodes);
    return command;
}

CLI::App* add_batch(CLI::App& app, Arguments& arguments, Words& words) {
    CLI::App* batch = add_command(app, "batch", "mortise batch LIST -o FOLDER [OPTIONS]",
                                  "mesh every model of a list, one path a line");
    batch->add_option("LIST", arguments.file);
    batch->add_option("-o,--output", arguments.outputs, "folder for one mesh file per model")
        ->option_text("FOLDER");
    batch->add_option("--format", arguments.format, "of the mesh files: vtu (default) or msh")
        ->option_text("vtu|msh");
    batch->add_option("--jobs", words.jobs, "models meshed at once, default all cores")->option_text("COUNT");
    add_shape_options(*batch, arguments, words);
    add_size_options(*batch, arguments, words);
    add_element_options(*batch, arguments, words);
    batch->option_defaults()->group("Reports and running");
    batch->add_flag("--check", arguments.check, "validate every mesh; write none that has defects");
    CLI::Option* json = batch->add_flag("--json", arguments.json, "print one JSON object a line");
    batch->add_flag("--quiet", arguments.quiet, "print failures only")->excludes(json);
    add_device_options(*batch, arguments, words);
    add_file_options(*batch, words);
    refuse_empty_values(*batch);
    return batch;
}

/// What belongs behind an option, for messages.
std::string values_of(const std::string& option) {
    if (option == "--box") return "six numbers, X0 Y0 Z0 X1 Y1 Z1";
    if (option == "--size-of") return "two values, NAME H: a region or surface, and a length";
    if (option == "--size-at") return "five numbers, X Y Z H G: a point, a length there, and its growth";
    return "a value";
}

/// A word that CLI11 has no use for: an option may be another command's.
[[noreturn]] void refuse_extra(const CLI::App& app, const std::string& word) {
    const std::vector<const CLI::App*> named =
        app.get_subcommands([](const CLI::App* command) { return command->parsed(); });
    if (named.empty()) refuse("unexpected argument '" + word + "'; see mortise --help");
    const std::string command = "mortise " + named.front()->get_name();
    const bool is_option = word.size() > 1 && word.front() == '-' &&
                           app.get_option_no_throw(word.substr(0, word.find('='))) != nullptr;
    refuse(is_option ? "'" + word + "' is for meshing a single model, not for " + command +
                           "; leave it away, see " + command + " --help"
                     : "unexpected argument '" + word + "'; see " + command + " --help");
}

void read_extrude(const std::string& word, Arguments& arguments) {
    if (word.empty()) return;
    arguments.read.extrude = parse_number("--extrude", word);
    if (!(arguments.read.extrude > 0)) refuse("--extrude '" + word + "': expected a positive length");
}

double parse_length(const std::string& option, const std::string& word) {
    const double length = parse_number(option, word);
    if (length <= 0) refuse(option + " '" + word + "': expected a positive length");
    return length;
}

int parse_levels(const std::string& option, const std::string& word) {
    if (word.empty()) return 0;
    const int levels = parse_integer(option, word, 0, " to 18");
    if (levels > kMaxLevel) refuse(option + " '" + word + "': expected a whole number from 0 to 18");
    return levels;
}

/// Options that make cells of several sizes.
void read_size_words(const Words& words, MeshOptions& options) {
    options.refine = parse_levels("--refine", words.refine);
    options.interior_coarsening = parse_levels("--interior-coarsening", words.coarsening);
    options.model_sizes = !words.no_model_sizes;
    if (!words.curvature.empty()) {
        options.curvature_elements = parse_number("--curvature-elements", words.curvature);
        if (options.curvature_elements < 3) {
            refuse("--curvature-elements '" + words.curvature + "': expected a number from 3");
        }
    }
    if (!words.size_max.empty()) options.size_max = parse_length("--size-max", words.size_max);
    for (std::size_t i = 0; i + 1 < words.size_of.size(); i += 2) {
        options.named_sizes.emplace_back(words.size_of[i], parse_length("--size-of", words.size_of[i + 1]));
    }
    if (!words.size_min.empty()) options.size_min = parse_length("--size-min", words.size_min);
    for (std::size_t i = 0; i + 4 < words.size_at.size(); i += 5) {
        SizeSource source;
        for (std::size_t j = 0; j < 3; ++j) source.at[j] = parse_number("--size-at", words.size_at[i + j]);
        source.size = parse_length("--size-at", words.size_at[i + 3]);
        source.grading = parse_number("--size-at", words.size_at[i + 4]);
        if (source.grading < 0) {
            refuse("--size-at '" + words.size_at[i + 4] + "': expected a growth of 0 or more");
        }
        options.sizes.push_back(source);
    }
}

/// Of the mesher, `batch` and `info`.
void read_model_words(const Words& words, Arguments& arguments) {
    read_extrude(words.extrude, arguments);
    if (!words.facets.empty() && words.facets != "smooth" && words.facets != "exact") {
        refuse("--facets '" + words.facets + "': expected smooth or exact");
    }
    if (words.facets == "exact") arguments.read.facets = Facets::kExact;
}

void read_mesh_words(const Words& words, Arguments& arguments) {
    MeshOptions& options = arguments.options;
    read_model_words(words, arguments);
    if (!words.level.empty())
        options.level = parse_integer("--level", words.level, 1, " to 10; the default is 6");
    if (!words.size.empty()) options.size = parse_length("--size", words.size);
    read_size_words(words, options);
    options.box_fit = words.box_fit;
    if (!words.box.empty()) {
        Box3 box;
        for (std::size_t i = 0; i < 6; ++i) {
            (i < 3 ? box.min : box.max)[i % 3] = parse_number("--box", words.box[i]);
        }
        options.box = box;
    }
    if (!words.elements.empty() && words.elements != "hex" && words.elements != "tet") {
        refuse("--elements '" + words.elements + "': expected hex or tet");
    }
    options.tetrahedra = words.elements == "tet";
    options.hanging = words.hanging;
    if (options.hanging && options.tetrahedra)
        refuse("--hanging and --elements tet: only hexahedra have hanging nodes; leave one away");
    options.templates = !words.no_templates;
    options.snap = !words.no_snap;
    options.improve = !words.no_improve;
    arguments.file_options.compress = !words.no_compress;
    if (!words.smooth.empty()) {
        options.smooth = parse_integer("--smooth", words.smooth, 0, " to 100");
        if (options.smooth > kMostSmooth)
            refuse("--smooth '" + words.smooth + "': expected a whole number from 0 to 100");
    }
    if (!words.min_angle.empty()) {
        options.min_angle = parse_number("--min-angle", words.min_angle);
        if (!(options.min_angle >= kLeastMinAngle && options.min_angle <= kMostMinAngle))
            refuse("--min-angle '" + words.min_angle + "': expected 18 to 35 degrees");
        if (words.no_improve && options.min_angle > kLeastMinAngle)
            refuse("--min-angle and --no-improve: elements reach larger angles by being improved only");
    }
    if (!words.merge.empty()) {
        options.merge_distance = parse_number("--merge", words.merge);
        if (options.merge_distance < 0 || options.merge_distance > kMostMergeDistance)
            refuse("--merge '" + words.merge + "': expected a part of a cell, from 0 to 0.25");
    }
    options.quality = arguments.quality;
    if (!words.floor.empty()) {
        arguments.quality_floor = parse_number("--quality-floor", words.floor);
        if (arguments.quality_floor < 0 || arguments.quality_floor > 1) {
            refuse("--quality-floor '" + words.floor + "': expected a scaled Jacobian from 0 to 1");
        }
    }
    if (!words.threads.empty()) options.threads = parse_integer("--threads", words.threads, 1, "");
    if (!words.work_group.empty()) {
        options.work_group_size = parse_integer("--work-group", words.work_group, 1, "");
    }
}

/// A whole number of bytes with a unit: 4G, 800M.
std::uint64_t parse_bytes(const std::string& option, const std::string& word) {
    char* end = nullptr;
    const double value = std::strtod(word.c_str(), &end);
    const std::string unit = end;
    const int shift = unit == "G" ? 30 : unit == "M" ? 20 : unit == "K" ? 10 : -1;
    const double bytes = shift < 0 ? -1 : std::ldexp(value, shift);
    if (end == word.c_str() || !(bytes >= 1) || !(bytes < 0x1p62)) {
        refuse(option + " '" + word + "': expected a number and a unit, such as 4G or 800M");
    }
    return static_cast<std::uint64_t>(bytes);
}

/// What needs the whole mesh in memory.
void read_memory(const std::string& word, Arguments& arguments) {
    if (word.empty()) return;
    arguments.options.memory = parse_bytes("--memory", word);
    arguments.in_parts = true;
    const std::pair<bool, const char*> wrong[] = {{arguments.check, "--check"},
                                                  {arguments.quality, "--quality"},
                                                  {!arguments.features.empty(), "--features"},
                                                  {!arguments.picture.empty(), "--picture"},
                                                  {arguments.options.tetrahedra, "--elements tet"}};
    for (const auto& [is_given, option] : wrong) {
        if (is_given)
            refuse(std::string(option) + " needs the whole mesh in memory; leave it or --memory away");
    }
}

/// Gmsh's format would lose which nodes hang.
void refuse_hanging_msh(const std::string& option, const std::string& value) {
    refuse(option + " '" + value +
           "': .msh files have no place for hanging nodes; use .vtu, or leave --hanging "
           "away");
}

void check_files(const Arguments& arguments) {
    if (arguments.file.empty())
        refuse("no model given; use: mortise MODEL -o FILE.vtu, or see mortise --help");
    if (arguments.outputs.empty()) {
        refuse("no output given for '" + arguments.file + "'; add -o FILE.vtu or -o FILE.msh");
    }
    for (auto path = arguments.outputs.begin(); path != arguments.outputs.end(); ++path) {
        if (std::any_of(arguments.outputs.begin(), path,
                        [&](const std::string& before) { return is_same_file(before, *path); }))
            refuse("-o '" + *path + "': given twice");
        if (arguments.options.hanging && path->size() >= 4 &&
            lower_case(path->substr(path->size() - 4)) == ".msh")
            refuse_hanging_msh("-o", *path);
    }
}

void read_batch_words(const Words& words, Arguments& arguments) {
    if (arguments.file.empty()) refuse("no list given; use: mortise batch LIST -o FOLDER");
    if (arguments.outputs.size() != 1) refuse("batch: expected one folder for the meshes; add -o FOLDER");
    const std::string format = lower_case(arguments.format);
    if (format != "vtu" && format != "msh") {
        refuse("--format '" + arguments.format + "': expected vtu or msh");
    }
    if (arguments.options.hanging && format == "msh") refuse_hanging_msh("--format", arguments.format);
    arguments.format = format;
    if (!words.jobs.empty()) arguments.jobs = parse_integer("--jobs", words.jobs, 1, "");
}

}  // namespace

Arguments parse_arguments(int count, const char* const* values) {
    Arguments arguments;
    Words words;
    CLI::App app("Mortise turns CSG solids into conforming, mostly hexahedral volume meshes.");
    app.formatter(std::make_shared<HelpFormatter>("mortise MODEL -o FILE [-o FILE ...] [OPTIONS]"));
    app.set_help_flag("-h,--help", "print this help");
    add_mesh_options(app, arguments, words);

    CLI::App* batch = add_batch(app, arguments, words);
    CLI::App* check = add_command(app, "check", "mortise check FILE [--quality] [--json]",
                                  "validate a mesh file, .vtu or .msh");
    check->add_option("FILE", arguments.file);
    check->add_flag("--quality", arguments.quality, "report the elements' shapes, too");
    CLI::App* devices = add_command(app, "devices", "mortise devices [--json]", "list OpenCL devices");
    CLI::App* doctor =
        add_command(app, "doctor", "mortise doctor", "check the OpenCL installation, and how to repair it");
    CLI::App* info = add_command(
        app, "info", "mortise info MODEL [-D NAME=VALUE] [--extrude H] [--facets smooth|exact] [--json]",
        "what a model holds, without meshing it");
    info->add_option("MODEL", arguments.file);
    info->add_option("--extrude", words.extrude, "height of the solid above a function of x and y")
        ->option_text("H");
    add_facets(*info, words);
    add_define(*info, arguments);
    for (CLI::App* command : {check, devices, info}) {
        refuse_empty_values(*command);
        command->add_flag("--json", arguments.json, "print JSON on stdout");
    }

    try {
        app.parse(count, values);
    } catch (const CLI::CallForHelp&) {
        // The help wanted is that of the command, if one was named before --help.
        const std::vector<CLI::App*> named = app.get_subcommands();
        arguments.command = Command::kPrint;
        arguments.text = (named.empty() ? &app : named.front())->help();
        return arguments;
    } catch (const CLI::CallForVersion& version) {
        arguments.command = Command::kPrint;
        arguments.text = std::string(version.what()) + "\n";
        return arguments;
    } catch (const CLI::ExtrasError&) {
        const std::vector<std::string> extra = app.remaining(true);
        refuse_extra(app, extra.empty() ? "" : extra.front());
    } catch (const CLI::ArgumentMismatch& error) {
        // CLI11 says "--level: 1 required TEXT missing".
        const std::string what = error.what();
        const std::string option = what.substr(0, what.find(':'));
        refuse(option + ": expected " + values_of(option) + "; see mortise --help");
    } catch (const CLI::ParseError& error) {
        refuse(std::string(error.what()) + "; see mortise --help");
    }

    if (batch->parsed()) arguments.command = Command::kBatch;
    if (check->parsed()) arguments.command = Command::kCheck;
    if (devices->parsed()) arguments.command = Command::kDevices;
    if (doctor->parsed()) arguments.command = Command::kDoctor;
    if (info->parsed()) arguments.command = Command::kInfo;
    if (arguments.command == Command::kMesh || batch->parsed()) read_mesh_words(words, arguments);
    if (arguments.command == Command::kMesh) {
        check_files(arguments);
        read_memory(words.memory, arguments);
    }
    if (batch->parsed()) read_batch_words(words, arguments);
    if (check->parsed() && arguments.file.empty()) refuse("no mesh given; use: mortise check FILE");
    if (info->parsed()) read_model_words(words, arguments);
    if (info->parsed() && arguments.file.empty()) refuse("no model given; use: mortise info MODEL");
    return arguments;
}

}  // namespace mortise::cli
