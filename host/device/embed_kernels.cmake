# Builds the generator, runs it over kernels/ and adds its output to mortise_device; then says what the
# device layer needs. Included by host/CMakeLists.txt after mortise_part(device).
add_executable(embed_kernels
  ${CMAKE_CURRENT_LIST_DIR}/embed/embed_kernels.cpp
  ${CMAKE_CURRENT_LIST_DIR}/flatten.cpp)

set(mortise_kernels_folder ${PROJECT_SOURCE_DIR}/kernels)
set(mortise_embedded ${CMAKE_CURRENT_BINARY_DIR}/embedded_kernels.cpp)
file(GLOB_RECURSE mortise_kernel_files CONFIGURE_DEPENDS
  ${mortise_kernels_folder}/*.cl ${mortise_kernels_folder}/*.h ${mortise_kernels_folder}/*.def)
add_custom_command(
  OUTPUT ${mortise_embedded}
  COMMAND embed_kernels ${mortise_kernels_folder} ${mortise_embedded}
  DEPENDS embed_kernels ${mortise_kernel_files}
  COMMENT "Embedding kernels"
  VERBATIM)
target_sources(mortise_device PRIVATE ${mortise_embedded})

# Kernels that are compiled when Mortise is installed are looked for from where the program is.
include(GNUInstallDirs)
file(RELATIVE_PATH program_to_libraries /prefix/${CMAKE_INSTALL_BINDIR} /prefix/${CMAKE_INSTALL_LIBDIR})
target_compile_definitions(mortise_device PRIVATE MORTISE_PROGRAM_TO_LIBRARIES="${program_to_libraries}")
target_link_libraries(mortise_device PRIVATE ${CMAKE_DL_LIBS})

# Private: nothing outside host/device sees OpenCL.
target_compile_definitions(mortise_device PRIVATE CL_TARGET_OPENCL_VERSION=120)
target_link_libraries(mortise_device PRIVATE OpenCL::OpenCL clblast Boost::headers)
