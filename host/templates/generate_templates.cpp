// Writes the template table: generate_templates FILE (kernels/shared/template_table.h).
#include <cstdio>
#include <fstream>

#include "host/templates/table.hpp"
#include "mortise/error.hpp"

namespace {

void write_table(const char* path) {
    const std::string text = mortise::templates::table_text(mortise::templates::build_table());
    std::ofstream file(path, std::ios::binary);
    file << text;
    file.close();
    if (!file) {
        throw mortise::Error(mortise::ExitCode::kFiles, std::string("template table '") + path +
                                                            "': cannot be written; check that its folder "
                                                            "exists and may be written to");
    }
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 2) {
        std::fprintf(stderr, "usage: generate_templates FILE\n");
        return static_cast<int>(mortise::ExitCode::kUsage);
    }
    try {
        write_table(argv[1]);
    } catch (const mortise::Error& error) {
        std::fprintf(stderr, "generate_templates: %s\n", error.what());
        return static_cast<int>(error.code());
    }
    return 0;
}
