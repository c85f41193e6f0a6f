# Builds the generator, runs it over kernels/ and adds its output to mortise_device; then says what the
# device layer needs. Included by host/CMakeLists.txt after mortise_part(device).
add_executable(embed_kernels
  ${CMAKE_CURRENT_LIST_DIR}/embed/embed_kernels.cpp
  ${CMAKE_CURRENT_LIST_DIR}/flatten.cpp)

set(mortise_kernels_folder ${CMAKE_SOURCE_DIR}/kernels)
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

# Private: nothing outside host/device sees OpenCL.
target_compile_definitions(mortise_device PRIVATE CL_TARGET_OPENCL_VERSION=120)
target_link_libraries(mortise_device PRIVATE OpenCL::OpenCL clblast Boost::headers)
