# A build whose own code is watched while it runs: MODSEARCH_SANITIZE=address adds the address and undefined-behaviour
# sanitizers, =thread the thread sanitizer. The first finding ends the program, so that no test can pass over it.
set(MODSEARCH_SANITIZE "" CACHE STRING "Sanitizers of the build: address (with undefined), thread, or empty")
set_property(CACHE MODSEARCH_SANITIZE PROPERTY STRINGS "" address thread)
option(MODSEARCH_BUILD_FUZZERS "Build the fuzzers of the readers (fuzz/); needs clang" OFF)

if(MODSEARCH_BUILD_FUZZERS)
  if(NOT CMAKE_CXX_COMPILER_ID STREQUAL "Clang")
    message(FATAL_ERROR "The fuzzers need clang (-DCMAKE_CXX_COMPILER=clang++-14); this is ${CMAKE_CXX_COMPILER_ID}")
  endif()
  add_compile_options(-fsanitize=fuzzer-no-link)  # counts which branches an input takes
  add_link_options(-fsanitize=fuzzer-no-link)
endif()
if(NOT MODSEARCH_SANITIZE)
  return()
endif()

if(MODSEARCH_SANITIZE STREQUAL "address")
  # float-cast-overflow is not part of `undefined`; readers turn numbers of files into integers. Left out are checks of
  # every pointer that is used: the address sanitizer and the processor find what they find, and they take a third of the
  # time that Eigen's templates compile.
  set(sanitizers -fsanitize=address,undefined,float-cast-overflow -fno-sanitize=null,alignment,object-size
                 -fno-sanitize-recover=all)
elseif(MODSEARCH_SANITIZE STREQUAL "thread")
  set(sanitizers -fsanitize=thread)
else()
  message(FATAL_ERROR "MODSEARCH_SANITIZE is ${MODSEARCH_SANITIZE}; it may be address or thread")
endif()
# Light optimisation: findings keep their lines, and the tests end on the same day. Assertions of Eigen and of the
# standard library are on, because a sanitizer does not see an index that is wrong within one array.
add_compile_options(${sanitizers} -fno-omit-frame-pointer -O1 -g1 -UNDEBUG -D_GLIBCXX_ASSERTIONS)
add_link_options(${sanitizers})
