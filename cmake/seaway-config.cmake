# find_package(seaway): the target seaway::seaway, the C interface of seaway/seaway.h.
include(${CMAKE_CURRENT_LIST_DIR}/seaway-targets.cmake)
