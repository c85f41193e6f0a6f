// The surroundings of an OpenCL driver. PoCL aborts, or hides its device, when its cache folder or the linker
// is not what it expects; each case is answered here before the first OpenCL call.
#pragma once

#include <string>

namespace mortise::device {

/// Makes PoCL's surroundings sound, once per process, before the first OpenCL call: an empty POCL_CACHE_DIR
/// is unset, a cache folder that cannot be written is replaced by a private temporary one, and kernels are
/// compiled once, for any size of work-groups, unless POCL_WORK_GROUP_SPECIALIZATION says otherwise: compiled
/// again for ours they are no faster. Work-items run one by one, unless POCL_WORK_GROUP_METHOD says
/// otherwise: ours have lanes of their own, and LLVM would make several into lanes with gather instructions.
/// Changes the environment, so no other thread may read it meanwhile.
void prepare_environment();

/// For processes that share a machine, before the first OpenCL call of this one and those it starts: PoCL
/// gets so many threads instead of one for each core, unless POCL_MAX_PTHREAD_COUNT says otherwise. No other
/// thread may read the environment meanwhile.
void limit_driver_threads(int threads);

/// Where PoCL keeps its compiled kernels; empty if neither HOME nor XDG_CACHE_HOME says.
std::string pocl_cache_folder();

/// Full path of a program on PATH, or empty.
std::string find_on_path(const std::string& program);

/// $MORTISE_CACHE, else $XDG_CACHE_HOME/mortise, else ~/.cache/mortise; empty if none is set. The folder
/// need not exist.
std::string cache_folder();

/// Creates the folder if need be and a file in it; false if that fails.
bool is_writable_folder(const std::string& folder);

}  // namespace mortise::device
