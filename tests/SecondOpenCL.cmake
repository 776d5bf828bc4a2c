# The kernel suites once more on other OpenCL implementations than the default one. Oclgrind interprets each work-item
# and also fails on accesses out of bounds, data races and wrong API calls; rusticl compiles for the CPU by another way
# (the partition for CPUs not within many minutes).
if(NOT HOLDFAST_SECOND_OPENCL)
  return()
endif()

find_program(OCLGRIND oclgrind)
if(NOT OCLGRIND)
  message(WARNING "There is no oclgrind: kernels are not checked for accesses out of bounds and races")
endif()

# What Oclgrind finds fails a test: its exit code is the tested program's. Without --uninitialized: it does not know that
# clEnqueueFillBuffer initialises.
set(oclgrind_findings "Invalid (read|write|memory) |data race at|divergence detected|error detected|OCLGRIND|test cases: +0 ")
foreach(source ${kernels})
  get_filename_component(suite ${source} NAME_WE)
  if(OCLGRIND)
    add_test(NAME ${suite}_oclgrind COMMAND ${OCLGRIND} --check-api --data-races $<TARGET_FILE:test_kernels>
      --source-file=*/${source} "--test-case-exclude=*640x480*")  # ten minutes, interpreted; rusticl runs them
    set_tests_properties(${suite}_oclgrind PROPERTIES
      ENVIRONMENT "HOLDFAST_DEVICE=oclgrind;HOLDFAST_CACHE_DIR=${CMAKE_CURRENT_BINARY_DIR}/cache_oclgrind"
      FAIL_REGULAR_EXPRESSION "${oclgrind_findings}" LABELS second_opencl TIMEOUT 600)
  endif()
  add_test(NAME ${suite}_rusticl COMMAND test_kernels --source-file=*/${source})
  set_tests_properties(${suite}_rusticl PROPERTIES
    ENVIRONMENT "RUSTICL_ENABLE=llvmpipe;HOLDFAST_DEVICE=rusticl;HOLDFAST_TEST_PARTITION=groups;HOLDFAST_CACHE_DIR=${CMAKE_CURRENT_BINARY_DIR}/cache_rusticl"
    FAIL_REGULAR_EXPRESSION "test cases: +0 " LABELS second_opencl TIMEOUT 600
    # Mesa 26 without the libclc that was made for it: no kernel that calls a function of it links.
    SKIP_REGULAR_EXPRESSION "Internal compilation error: nir_shader not fully linked")
endforeach()
