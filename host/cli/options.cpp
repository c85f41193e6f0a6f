// What CLI11 is told of the command line: options, commands, help.
#include "host/cli/options.hpp"

#include <memory>
#include <string>

#include "host/cli/help_formatter.hpp"

namespace mortise::cli {
namespace {

constexpr const char* kExamples = R"(Examples: mortise bracket.csg -o bracket.vtu --picture bracket.png
)";

constexpr const char* kExitCodes =
    R"(Exit codes: 0 success                       4 quality floor not met (mesh is written)
            1 wrong usage                   5 no OpenCL device, kernel build, memory
            2 model not understood, empty   6 file not found, not readable or writable
            3 no valid mesh; --strict       130, 143 interrupted (SIGINT, SIGTERM)
)";

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
    app.add_option("--periodic", arguments.options.periodic,
                   "opposite faces of the box alike, node for node: xyz, or some of these")
        ->option_text("AXES");
    app.add_option("--extrude", words.extrude, "solid of height H above a function of x and y (.vm, .frep)")
        ->option_text("H");
    add_facets(app, words);
}

void add_model_options(CLI::App& app, Arguments& arguments, Words& words) {
    app.add_option("MODEL", arguments.file,
                   "model file: .csg, .scad, .geo, .stl, .obj, .off, .formula, .vm or .frep");
    app.add_option("-o,--output", arguments.outputs,
                   ".vtu, .msh, .inp, .stl (surface), OpenFOAM's folder polyMesh; repeatable")
        ->option_text("FILE")
        ->allow_extra_args(false);
    add_shape_options(app, arguments, words);
}
void add_size_options(CLI::App& app, Arguments& arguments, Words& words) {
    app.option_defaults()->group("Sizes of cells");
    CLI::Option* level =
        app.add_option("--level", words.level, "split the root cube LEVEL times: 1 to 11, default 6")
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
    app.add_flag("--no-model-sizes", words.no_model_sizes, "ignore element sizes in the file (-maxh)")
        ->group("");  // few files have any
    app.add_option("--interior-coarsening", words.coarsening, "cells inside up to N levels larger")
        ->option_text("N");
    app.add_flag("--box-fit", words.box_fit,
                 "enlarge cells a little so that faces of the model lie on the grid")
        ->group("");  // few need it; docs/options.md has it
}

void add_element_options(CLI::App& app, Arguments& arguments, Words& words) {
    app.option_defaults()->group("Elements");
    app.add_option("--elements", words.elements, "hex: mostly hexahedra (default); tet: tetrahedra only")
        ->option_text("hex|tet");
    app.add_option("--order", words.order, "2: elements of second order, curved as the model (1)")
        ->option_text("1|2");
    app.add_flag("--hanging", words.hanging,
                 "cells inside beside smaller ones stay hexahedra, with hanging nodes");
    app.add_option("--layers", words.layers, "N layers of flat elements at walls")->option_text("N");
    app.add_option("--first-layer", words.first_layer,
                   "height of the one at the wall (0.4 of a facet's edge)")
        ->option_text("LENGTH");
    app.add_option("--layer-growth", words.layer_growth, "height of each to the one before it (1.2)")
        ->option_text("X");
    app.add_option("--layers-on", arguments.options.layers.on,
                   "walls: that surface, or a region's boundary (all; repeatable)")
        ->option_text("NAME")
        ->allow_extra_args(false);
    app.add_option("--min-angle", words.min_angle, "smallest dihedral angle that elements get, 18 to 44 (18)")
        ->option_text("ANGLE");
    app.add_option("--smooth", words.smooth, "rounds of moving nodes to better places, 0 to 100 (4)")
        ->option_text("ROUNDS")
        ->group("");  // more than the default is hardly ever better
    app.add_option("--merge", words.merge,
                   "instead of slivers, nodes may merge within X cells, or move 3 X (0.05)")
        ->option_text("X");
    app.add_flag("--no-improve", words.no_improve, "leave elements as templates and certificate make them")
        ->group("");  // for developers
    // For developers; docs/options.md has them.
    app.add_flag("--no-snap", words.no_snap, "do not move grid vertices onto the surface")->group("");
    app.add_flag("--no-templates", words.no_templates, "mesh simple surface cells like complex ones")
        ->group("");
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
        ->option_text("COUNT")
        ->group("");  // for developers
}

void add_file_options(CLI::App& app, Words& words) {
    app.add_flag("--no-compress", words.no_compress,
                 "plain arrays in .vtu: written faster, 4 times as large");
    app.add_option("--scale", words.scale, "coordinates in files times X: 0.001, mm to m")->option_text("X");
}

void add_output_options(CLI::App& app, Arguments& arguments, Words& words) {
    app.option_defaults()->group("Reports and running");
    app.add_flag("--dry-run", words.dry_run, "tell elements, memory and time roughly; make no mesh");
    app.add_flag("--check", arguments.check, "validate the mesh first; write nothing if it has defects");
    app.add_flag("--quality", arguments.quality, "report shapes, distance to the model, features");
    app.add_option("--features", arguments.features, "write creases and corners, .vtp")->option_text("FILE");
    app.add_option("--picture", arguments.picture, "draw the mesh, .png")->option_text("FILE");
    app.add_option("--cut", words.cut, "open it across x, y or z: in the middle, or at x=4.5")
        ->option_text("AXIS");
    app.add_option("--report", arguments.report, "write figures and times, .json")->option_text("FILE");
    app.add_flag("--json", arguments.json, "print the report on stdout, not the summary");
    app.add_flag("--quiet", arguments.quiet, "no summary and no progress; warnings stay");
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
    batch->add_option("--format", arguments.format, "of the mesh files: vtu (default), msh, inp or stl")
        ->option_text("vtu|msh|inp|stl");
    batch->add_option("--jobs", words.jobs, "models meshed at once, default all cores")->option_text("COUNT");
    batch->add_option("--time-limit", words.time_limit, "give up a model after so many seconds")
        ->option_text("SECONDS");
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

}  // namespace

Commands declare_options(CLI::App& app, Arguments& arguments, Words& words) {
    Commands commands;
    app.formatter(std::make_shared<HelpFormatter>("mortise MODEL -o FILE [-o FILE ...] [OPTIONS]"));
    app.set_help_flag("-h,--help", "print this help");
    add_mesh_options(app, arguments, words);

    commands.batch = add_batch(app, arguments, words);
    CLI::App* check = commands.check = add_command(app, "check", "mortise check FILE [--quality] [--json]",
                                                   "validate a mesh file, .vtu or .msh");
    check->add_option("FILE", arguments.file);
    check->add_flag("--quality", arguments.quality, "report the elements' shapes, too");
    CLI::App* devices = commands.devices =
        add_command(app, "devices", "mortise devices [--json]", "list OpenCL devices");
    commands.doctor =
        add_command(app, "doctor", "mortise doctor", "check the OpenCL installation, and how to repair it");
    CLI::App* info = commands.info = add_command(
        app, "info", "mortise info MODEL [-D NAME=VALUE] [--extrude H] [--facets smooth|exact] [--json]",
        "what a model holds, without meshing it");
    info->add_option("MODEL", arguments.file);
    info->add_option("--extrude", words.extrude, "height of the solid above a function of x and y")
        ->option_text("H");
    add_facets(*info, words);
    add_define(*info, arguments);
    CLI::App* kernels = commands.kernels =
        add_command(app, "kernels", "mortise kernels [-o FOLDER] [OPTIONS]",
                    "compile all kernels now, for later runs or all users");
    kernels
        ->add_option("-o,--output", arguments.outputs,
                     "a folder of its own instead of the cache folder: see README.md, Installing")
        ->option_text("FOLDER")
        ->allow_extra_args(false);
    add_device_options(*kernels, arguments, words);
    for (CLI::App* command : {check, devices, info, kernels}) {
        refuse_empty_values(*command);
        command->add_flag("--json", arguments.json, "print JSON on stdout");
    }
    return commands;
}

}  // namespace mortise::cli
