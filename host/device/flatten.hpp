// Flattens a kernel file: every #include "..." is replaced by the file's text, with #line directives that
// keep the compiler's messages at the real file and line. Shared by the build (embed/embed_kernels.cpp) and
// by the run-time loader (kernel_source.cpp), so that both give the same text.
#pragma once

#include <functional>
#include <optional>
#include <string>

namespace mortise::device {

/// Text of a file by its path below kernels/ ("shared/tape.h"), or nothing if there is no such file.
using KernelReader = std::function<std::optional<std::string>(const std::string& path)>;

/// Reads below a folder of the file system.
KernelReader folder_reader(const std::string& kernels_folder);

/// The text of kernels/`file` with its includes in place.
///
/// An include is looked up beside the file that names it, then below kernels/, and may be written with a
/// leading "kernels/". Each file is taken once, as if it began with #pragma once (which is dropped: compilers
/// warn about it in a main file), except .def files, which are taken each time. #include <...> stays as it
/// is; only the host's compiler may see it. Throws Error(kDevice) with file and line for an unknown file.
std::string flatten_kernel(const std::string& file, const KernelReader& read);

}  // namespace mortise::device
