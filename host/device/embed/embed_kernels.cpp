// Build tool: writes every kernel file below a folder, flattened, into a C++ file as byte arrays.
//
//     embed_kernels KERNELS_FOLDER OUTPUT.cpp
//
// Takes all .cl files, sorted by path, so that the output depends on nothing else.
#include <algorithm>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <string>
#include <vector>

#include "host/device/flatten.hpp"

namespace {

std::vector<std::string> kernel_files(const std::filesystem::path& root) {
    std::vector<std::string> files;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(root)) {
        if (entry.is_regular_file() && entry.path().extension() == ".cl") {
            files.push_back(entry.path().lexically_relative(root).generic_string());
        }
    }
    std::sort(files.begin(), files.end());
    return files;
}

void write_bytes(std::ostream& out, const std::string& name, const std::string& text) {
    out << "const unsigned char " << name << "[] = {";
    for (std::size_t i = 0; i < text.size(); ++i) {
        out << (i % 32 == 0 ? "\n" : "") << static_cast<unsigned>(static_cast<unsigned char>(text[i])) << ',';
    }
    out << "0};\n";
}

void embed(const std::string& folder, const std::string& output) {
    using namespace mortise::device;
    const std::vector<std::string> files = kernel_files(folder);
    std::ofstream out(output, std::ios::binary);
    out << "// Generated from kernels/ by host/device/embed/embed_kernels.cpp.\n"
           "#include \"host/device/kernel_source.hpp\"\n\n"
           "namespace mortise::device {\nnamespace {\n";
    std::string table;
    for (std::size_t i = 0; i < files.size(); ++i) {
        const std::string name = "kernel_" + std::to_string(i);
        const std::string text = flatten_kernel(files[i], folder_reader(folder));
        write_bytes(out, name, text);
        table += "    {\"" + files[i] + "\", " + name + ", " + std::to_string(text.size()) + "},\n";
    }
    out << "}  // namespace\n\nconst EmbeddedKernel kEmbeddedKernels[] = {\n"
        << table << "};\nconst std::size_t kEmbeddedKernelCount = " << files.size()
        << ";\n\n}  // namespace mortise::device\n";
    out.close();
    if (!out) throw std::runtime_error("cannot write " + output);
}

}  // namespace

int main(int count, char** arguments) {
    if (count != 3) {
        std::cerr << "usage: embed_kernels KERNELS_FOLDER OUTPUT.cpp\n";
        return 1;
    }
    try {
        embed(arguments[1], arguments[2]);
    } catch (const std::exception& error) {
        std::cerr << "embed_kernels: " << error.what() << '\n';
        return 1;
    }
    return 0;
}
