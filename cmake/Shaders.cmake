# Compiles every shaders/*.comp to SPIR-V and embeds it in the library.
#
# Each kernel is built twice. "full" reads hot data through texel buffers and uses 64-bit integer atomics;
# "portable" reads through storage buffers and needs neither, for devices that lack them (see shaders/lib/read_buffers.glsl).
find_program(GLSLANG glslangValidator REQUIRED)

function(cmpg_embed_shaders target)
  file(GLOB kernels CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/shaders/*.comp)
  set(out ${PROJECT_BINARY_DIR}/spirv)
  file(MAKE_DIRECTORY ${out})
  set(includes "")
  set(table "")
  set(headers "")
  foreach(kernel IN LISTS kernels)
    get_filename_component(name ${kernel} NAME_WE)
    foreach(variant full portable)
      set(symbol ${name}_${variant})
      set(header ${out}/${symbol}.h)
      set(defines "")
      if(variant STREQUAL portable)
        set(defines -DCMPG_PORTABLE)
      endif()
      add_custom_command(OUTPUT ${header}
        COMMAND ${GLSLANG} --quiet --target-env vulkan1.3 -I${PROJECT_SOURCE_DIR}/shaders ${defines}
                --vn ${symbol} --depfile ${header}.d -o ${header} ${kernel}
        DEPENDS ${kernel} DEPFILE ${header}.d VERBATIM
        COMMENT "Compiling kernel ${symbol}")
      list(APPEND headers ${header})
      string(APPEND includes "#include \"${symbol}.h\"\n")
    endforeach()
    string(APPEND table "    {\"${name}\", ${name}_full, ${name}_portable},\n")
  endforeach()
  file(CONFIGURE OUTPUT ${out}/spirv_table.inc CONTENT
    "${includes}\nstatic const EmbeddedKernel kEmbeddedKernels[] = {\n${table}};\n" @ONLY)
  add_custom_target(cmpg_spirv DEPENDS ${headers})
  add_dependencies(${target} cmpg_spirv)
  set_source_files_properties(${PROJECT_SOURCE_DIR}/src/vk/spirv.cpp PROPERTIES OBJECT_DEPENDS "${headers}")
  target_include_directories(${target} PRIVATE ${out})
endfunction()
