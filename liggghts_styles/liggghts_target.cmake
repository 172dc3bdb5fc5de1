# What every source that sees LIGGGHTS compiles with, here and in projects that use the installed package.
# -isystem, because LIGGGHTS' headers are not free of warnings; hidden visibility, because otherwise our
# instances of LIGGGHTS' templates would replace the library's own ones.
function(add_liggghts_target include_dir generated_dir library)
  add_library(liggghts INTERFACE IMPORTED GLOBAL)
  target_include_directories(liggghts SYSTEM INTERFACE ${include_dir} ${generated_dir})
  target_link_libraries(liggghts INTERFACE ${library} MPI::MPI_C)
  target_compile_definitions(liggghts INTERFACE OMPI_SKIP_MPICXX=1)
  target_compile_options(liggghts INTERFACE -fvisibility=hidden -fvisibility-inlines-hidden)
endfunction()
