# Compiles every *.comp of a folder to SPIR-V and generates the table that embeds it in a target.
#
# Each kernel is built three times. "full" reads hot data through texel buffers and uses 64-bit integer atomics, "cpu" is the same with storage
# texel buffers, which CPU drivers read faster; "portable" reads through storage buffers and needs neither, for devices that lack them
# (see shaders/lib/read_buffers.glsl).
find_program(GLSLANG glslangValidator REQUIRED)

# `source`, a file of the target, includes the generated spirv_table.inc: the vector kEmbeddedKernels of EmbeddedKernel.
function(cmpg_embed_shaders target folder source)
  file(GLOB kernels CONFIGURE_DEPENDS ${folder}/*.comp)
  set(out ${CMAKE_CURRENT_BINARY_DIR}/${target}_spirv)
  file(MAKE_DIRECTORY ${out})
  set(includes "")
  set(table "")
  set(headers "")
  foreach(kernel IN LISTS kernels)
    get_filename_component(name ${kernel} NAME_WE)
    foreach(variant full cpu portable)
      set(symbol ${name}_${variant})
      set(header ${out}/${symbol}.h)
      set(defines "")
      if(variant STREQUAL portable)
        set(defines -DCMPG_PORTABLE)
      elseif(variant STREQUAL cpu)
        set(defines -DCMPG_STORAGE_TEXELS)
      endif()
      add_custom_command(OUTPUT ${header}
        COMMAND ${GLSLANG} --quiet -g0 --target-env vulkan1.3 -I${PROJECT_SOURCE_DIR}/shaders ${defines} # names are a fifth of a kernel, to read and to keep
                --vn ${symbol} --depfile ${header}.d -o ${header} ${kernel}
        COMMAND ${CMAKE_COMMAND} -DHEADER=${header} -DSYMBOL=${symbol} -P ${PROJECT_SOURCE_DIR}/cmake/AppendDigest.cmake
        DEPENDS ${kernel} DEPFILE ${header}.d VERBATIM
        COMMENT "Compiling kernel ${symbol}")
      list(APPEND headers ${header})
      string(APPEND includes "#include \"${symbol}.h\"\n")
    endforeach()
    string(APPEND table "    {\"${name}\"")
    foreach(variant full cpu portable)
      string(APPEND table ", {${name}_${variant}, ${name}_${variant}_digest}")
    endforeach()
    string(APPEND table "},\n")
  endforeach()
  file(CONFIGURE OUTPUT ${out}/spirv_table.inc CONTENT
    "#include <vector>\n${includes}static const std::vector<cmpg::EmbeddedKernel> kEmbeddedKernels = {\n${table}};\n" @ONLY)
  add_custom_target(${target}_spirv DEPENDS ${headers})
  add_dependencies(${target} ${target}_spirv)
  set_source_files_properties(${source} PROPERTIES OBJECT_DEPENDS "${headers}")
  target_include_directories(${target} PRIVATE ${out})
endfunction()

# The graphics shaders of `folder` (*.vert, *.frag), for the sources of `target`: #include "panel_vert.h" defines panel_vert.
function(cmpg_embed_graphics_shaders target folder)
  file(GLOB shaders CONFIGURE_DEPENDS ${folder}/*.vert ${folder}/*.frag)
  set(out ${CMAKE_CURRENT_BINARY_DIR}/${target}_spirv)
  file(MAKE_DIRECTORY ${out})
  set(headers "")
  foreach(shader IN LISTS shaders)
    get_filename_component(symbol ${shader} NAME)
    string(REPLACE "." "_" symbol ${symbol})
    set(header ${out}/${symbol}.h)
    add_custom_command(OUTPUT ${header}
      COMMAND ${GLSLANG} --quiet --target-env vulkan1.3 -I${PROJECT_SOURCE_DIR}/shaders --vn ${symbol} --depfile ${header}.d -o ${header} ${shader}
      DEPENDS ${shader} DEPFILE ${header}.d VERBATIM
      COMMENT "Compiling shader ${symbol}")
    list(APPEND headers ${header})
  endforeach()
  target_sources(${target} PRIVATE ${headers}) # so that they are made before the sources are compiled
  target_include_directories(${target} PRIVATE ${out})
endfunction()
