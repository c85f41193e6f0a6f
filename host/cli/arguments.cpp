// The command line as data, by CLI11. Numbers are parsed here, so that every message names option and value.
#include "host/cli/arguments.hpp"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "host/cli/files.hpp"
#include "host/cli/options.hpp"
#include "host/common/lower_case.hpp"

namespace mortise::cli {
namespace {

[[noreturn]] void refuse(const std::string& message) { throw Error(ExitCode::kUsage, message); }

double parse_number(const std::string& option, const std::string& text) {
    char* end = nullptr;
    const double value = std::strtod(text.c_str(), &end);
    if (text.empty() || *end != '\0' || !std::isfinite(value)) {
        refuse(option + " '" + text + "': expected a finite number");
    }
    return value;
}

/// `hint`: what follows the range in messages.
int parse_integer(const std::string& option, const std::string& text, int smallest,
                  int largest = std::numeric_limits<int>::max(), const char* hint = "") {
    char* end = nullptr;
    errno = 0;
    const long value = std::strtol(text.c_str(), &end, 10);
    if (text.empty() || *end != '\0' || errno == ERANGE || value < smallest || value > largest) {
        const bool is_bounded = largest < std::numeric_limits<int>::max();
        refuse(option + " '" + text + "': expected a whole number from " + std::to_string(smallest) +
               (is_bounded ? " to " + std::to_string(largest) : "") + hint);
    }
    return static_cast<int>(value);
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
                           "; leave it out, see " + command + " --help"
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
    return parse_integer(option, word, 0, kMaxLevel);
}

/// Options that make cells of several sizes.
void read_size_words(const Words& words, MeshOptions& options) {
    options.refine = parse_levels("--refine", words.refine);
    options.interior_coarsening = parse_levels("--interior-coarsening", words.coarsening);
    options.model_sizes = !words.no_model_sizes;
    if (!words.curvature.empty())
        options.curvature_elements = parse_number("--curvature-elements", words.curvature);
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

/// Of the mesher, `batch` and `kernels`.
void read_device_words(const Words& words, Arguments& arguments) {
    MeshOptions& options = arguments.options;
    if (!words.threads.empty()) options.threads = parse_integer("--threads", words.threads, 1);
    if (!words.work_group.empty()) {
        options.work_group_size = parse_integer("--work-group", words.work_group, 1);
    }
}

void read_layer_words(const Words& words, MeshOptions& options) {
    LayerOptions& layers = options.layers;
    if (words.layers.empty()) {
        for (const auto& [is_given, option] :
             {std::pair<bool, const char*>{!words.first_layer.empty(), "--first-layer"},
              {!words.layer_growth.empty(), "--layer-growth"},
              {!layers.on.empty(), "--layers-on"}}) {
            if (is_given) refuse(std::string(option) + ": there are no layers; add --layers N");
        }
        return;
    }
    layers.count = parse_integer("--layers", words.layers, 1, kMostLayers);
    if (!words.first_layer.empty()) layers.first = parse_length("--first-layer", words.first_layer);
    if (!words.layer_growth.empty()) layers.growth = parse_number("--layer-growth", words.layer_growth);
}

void read_mesh_words(const Words& words, Arguments& arguments) {
    MeshOptions& options = arguments.options;
    read_model_words(words, arguments);
    if (!words.level.empty())
        options.level = parse_integer("--level", words.level, 1, kMostLevel, "; the default is 6");
    if (!words.size.empty()) options.size = parse_length("--size", words.size);
    read_size_words(words, options);
    options.box_fit = words.box_fit;
    if (!words.box.empty()) {
        Box3 box;
        for (std::size_t i = 0; i < 6; ++i) {
            (i < 3 ? box.min : box.max)[i % 3] = parse_number("--box", words.box[i]);
        }
        options.box = box;
        arguments.read.is_cut = true;
    }
    if (!words.elements.empty() && words.elements != "hex" && words.elements != "tet") {
        refuse("--elements '" + words.elements + "': expected hex or tet");
    }
    options.tetrahedra = words.elements == "tet";
    options.hanging = words.hanging;
    if (!words.order.empty() && words.order != "1" && words.order != "2")
        refuse("--order '" + words.order + "': expected 1 or 2");
    options.second_order = words.order == "2";
    read_layer_words(words, options);
    options.templates = !words.no_templates;
    options.snap = !words.no_snap;
    options.improve = !words.no_improve;
    arguments.file_options.compress = !words.no_compress;
    if (!words.scale.empty()) {
        arguments.file_options.scale = parse_number("--scale", words.scale);
        if (!(arguments.file_options.scale >= kLeastScale && arguments.file_options.scale <= kMostScale))
            refuse("--scale '" + words.scale + "': expected 1e-12 to 1e12");
    }
    if (!words.smooth.empty()) options.smooth = parse_integer("--smooth", words.smooth, 0, kMostSmooth);
    if (!words.min_angle.empty()) options.min_angle = parse_number("--min-angle", words.min_angle);
    if (!words.merge.empty()) options.merge_distance = parse_number("--merge", words.merge);
    options.quality = arguments.quality;
    if (!words.floor.empty()) {
        arguments.quality_floor = parse_number("--quality-floor", words.floor);
        if (arguments.quality_floor < 0 || arguments.quality_floor > 1) {
            refuse("--quality-floor '" + words.floor + "': expected a scaled Jacobian from 0 to 1");
        }
    }
    read_device_words(words, arguments);
    arguments.file_options.threads = options.threads;
    check_options(options);
}

/// Where the picture is cut: x, y or z, or with a place: x=4.5.
void read_cut(const std::string& word, Arguments& arguments) {
    if (word.empty()) return;
    if (arguments.picture.empty()) refuse("--cut: there is no picture; add --picture FILE.png");
    const std::size_t axis = std::string("xyz").find(word.front());
    if (axis == std::string::npos || (word.size() > 1 && word[1] != '='))
        refuse("--cut '" + word + "': expected x, y or z, or a place as in x=4.5");
    PictureCut cut;
    cut.axis = static_cast<int>(axis);
    if (word.size() > 1) cut.at = parse_number("--cut", word.substr(2));
    arguments.picture_options.cut = cut;
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
                                                  {arguments.options.tetrahedra, "--elements tet"},
                                                  {!arguments.options.periodic.empty(), "--periodic"},
                                                  {arguments.options.second_order, "--order 2"},
                                                  {arguments.options.layers.count > 0, "--layers"}};
    for (const auto& [is_given, option] : wrong) {
        if (is_given)
            refuse(std::string(option) + " needs the whole mesh in memory; leave out that or --memory");
    }
}

/// What needs a mesh that is made.
void read_dry_run(const Words& words, Arguments& arguments) {
    if (!words.dry_run) return;
    arguments.command = Command::kEstimate;
    const std::pair<bool, const char*> wrong[] = {{arguments.check, "--check"},
                                                  {arguments.quality, "--quality"},
                                                  {arguments.quality_floor >= 0, "--quality-floor"},
                                                  {!arguments.features.empty(), "--features"},
                                                  {!arguments.picture.empty(), "--picture"},
                                                  {!words.cut.empty(), "--cut"},
                                                  {!words.memory.empty(), "--memory"}};
    for (const auto& [is_given, option] : wrong) {
        if (is_given) refuse(std::string(option) + ": a dry run makes no mesh; leave out that or --dry-run");
    }
}

void check_files(const Arguments& arguments) {
    if (arguments.file.empty())
        refuse("no model given; use: mortise MODEL -o FILE.vtu, or see mortise --help");
    if (arguments.outputs.empty() && arguments.command == Command::kMesh) {
        refuse("no output given for '" + arguments.file + "'; add -o FILE.vtu or -o FILE.msh");
    }
    for (auto path = arguments.outputs.begin(); path != arguments.outputs.end(); ++path) {
        if (std::any_of(arguments.outputs.begin(), path,
                        [&](const std::string& before) { return is_same_file(before, *path); }))
            refuse("-o '" + *path + "': given twice");
        if (is_same_file(arguments.file, *path)) refuse("-o '" + *path + "': is the model itself");
    }
}

void read_batch_words(const Words& words, Arguments& arguments) {
    if (arguments.file.empty()) refuse("no list given; use: mortise batch LIST -o FOLDER");
    if (arguments.outputs.size() != 1) refuse("batch: expected one folder for the meshes; add -o FOLDER");
    const std::string format = lower_case(arguments.format);
    if (format != "vtu" && format != "msh" && format != "inp" && format != "stl")
        refuse("--format '" + arguments.format + "': expected vtu, msh, inp or stl");
    arguments.format = format;
    if (!words.jobs.empty()) arguments.jobs = parse_integer("--jobs", words.jobs, 1);
    if (words.time_limit.empty()) return;
    arguments.time_limit = parse_number("--time-limit", words.time_limit);
    if (!(arguments.time_limit > 0))
        refuse("--time-limit '" + words.time_limit + "': expected a positive number of seconds");
}

}  // namespace

Arguments parse_arguments(int count, const char* const* values) {
    Arguments arguments;
    Words words;
    CLI::App app("Mortise turns CSG solids into conforming, mostly hexahedral volume meshes.");
    const Commands commands = declare_options(app, arguments, words);

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
        // CLI11 says "--level: 1 required TEXT missing", "--level: At Most 1 required but received 2".
        const std::string what = error.what();
        const std::string option = what.substr(0, what.find(':'));
        if (what.find("At Most") != std::string::npos) refuse(option + " is given twice; expected it once");
        refuse(option + ": expected " + values_of(option) + "; see mortise --help");
    } catch (const CLI::ParseError& error) {
        refuse(std::string(error.what()) + "; see mortise --help");
    }

    if (commands.batch->parsed()) arguments.command = Command::kBatch;
    if (commands.check->parsed()) arguments.command = Command::kCheck;
    if (commands.devices->parsed()) arguments.command = Command::kDevices;
    if (commands.doctor->parsed()) arguments.command = Command::kDoctor;
    if (commands.info->parsed()) arguments.command = Command::kInfo;
    if (commands.kernels->parsed()) arguments.command = Command::kKernels;
    if (arguments.command == Command::kMesh || commands.batch->parsed()) read_mesh_words(words, arguments);
    if (commands.kernels->parsed()) read_device_words(words, arguments);
    if (arguments.command == Command::kMesh) {
        read_dry_run(words, arguments);
        check_files(arguments);
        read_cut(words.cut, arguments);
        read_memory(words.memory, arguments);
    }
    if (commands.batch->parsed()) read_batch_words(words, arguments);
    if (commands.check->parsed() && arguments.file.empty()) refuse("no mesh given; use: mortise check FILE");
    if (commands.info->parsed()) read_model_words(words, arguments);
    if (commands.info->parsed() && arguments.file.empty()) refuse("no model given; use: mortise info MODEL");
    return arguments;
}

}  // namespace mortise::cli
