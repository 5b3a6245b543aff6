# What `cmake --install` and `cpack` give to users, in four components: server, tools, library, development. Included
# last: every target is known. Design: docs/decisions/0046-packages.md; for users: docs/install.md.
include(GNUInstallDirs)
# Debian keeps libraries by architecture, below /usr/local too; CMake's rule for that looks at the prefix of the
# configuration, and packages have another.
set(libdir ${CMAKE_INSTALL_LIBDIR})
if(CMAKE_LIBRARY_ARCHITECTURE AND EXISTS /etc/debian_version)
  set(libdir lib/${CMAKE_LIBRARY_ARCHITECTURE})
endif()

# seaway_install_program(NAME COMPONENT): the program, its page of the manual and its completion for bash, both
# written by itself.
function(seaway_install_program name component)
  set(written ${PROJECT_BINARY_DIR}/written)
  add_custom_command(OUTPUT ${written}/${name}.1.gz ${written}/${name}.bash
    COMMAND ${CMAKE_COMMAND} -E make_directory ${written}
    COMMAND $<TARGET_FILE:${name}> --completion > ${written}/${name}.bash
    COMMAND $<TARGET_FILE:${name}> --manual > ${written}/${name}.1
    COMMAND gzip -9nf ${written}/${name}.1
    DEPENDS ${name} VERBATIM)
  add_custom_target(${name}-manual ALL DEPENDS ${written}/${name}.1.gz)
  install(TARGETS ${name} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT ${component})
  install(FILES ${written}/${name}.1.gz DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT ${component})
  install(FILES ${written}/${name}.bash DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions
    RENAME ${name} COMPONENT ${component})
endfunction()

# ---- server ------------------------------------------------------------------------------------
seaway_install_program(seaway-server server)
install(DIRECTORY scenes DESTINATION ${CMAKE_INSTALL_DATADIR}/seaway COMPONENT server)
# Below /usr configuration is in /etc, elsewhere in the prefix; the unit says so of its own prefix.
install(CODE "set(source \"${PROJECT_SOURCE_DIR}\")" COMPONENT server)
install(SCRIPT cmake/install_service.cmake COMPONENT server)

# ---- tools -------------------------------------------------------------------------------------
foreach(program seaway-query seaway-ctl seaway-view seaway-inspect seaway-bake seaway-bench)
  if(TARGET ${program})
    seaway_install_program(${program} tools)
  endif()
endforeach()
install(DIRECTORY looks DESTINATION ${CMAKE_INSTALL_DATADIR}/seaway COMPONENT tools)
# What seaway-bench measures where it is told nothing. A place of its own: no two packages have the same file.
install(FILES scenes/north_sea_gale.toml DESTINATION ${CMAKE_INSTALL_DATADIR}/seaway/bench COMPONENT tools)

# ---- library and development -------------------------------------------------------------------
install(TARGETS seaway_shared EXPORT seaway_targets
  LIBRARY DESTINATION ${libdir} COMPONENT library NAMELINK_COMPONENT development)
install(FILES client/seaway.h client/seaway.hpp client/seaway_engine.h client/buoyancy.h client/buoyancy_hull.h client/buoyancy_obj.h
  client/buoyancy_panel.h client/buoyancy_step.h DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/seaway
  COMPONENT development)
install(EXPORT seaway_targets FILE seaway-targets.cmake NAMESPACE seaway::
  DESTINATION ${libdir}/cmake/seaway COMPONENT development)
install(DIRECTORY examples DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/libseaway-dev COMPONENT development
  PATTERN CMakeLists.txt EXCLUDE PATTERN __pycache__ EXCLUDE)
include(CMakePackageConfigHelpers)
# Before 1.0 another minor version is another interface.
write_basic_package_version_file(${PROJECT_BINARY_DIR}/seaway-config-version.cmake
  COMPATIBILITY SameMinorVersion)
file(RELATIVE_PATH to_prefix /${libdir}/pkgconfig /)
configure_file(cmake/seaway.pc.in ${PROJECT_BINARY_DIR}/seaway.pc @ONLY)
install(FILES cmake/seaway-config.cmake ${PROJECT_BINARY_DIR}/seaway-config-version.cmake
  DESTINATION ${libdir}/cmake/seaway COMPONENT development)
install(FILES ${PROJECT_BINARY_DIR}/seaway.pc DESTINATION ${libdir}/pkgconfig COMPONENT development)

# ---- Debian packages ---------------------------------------------------------------------------
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_VENDOR Seaway)
set(CPACK_PACKAGE_HOMEPAGE_URL "")
set(SEAWAY_PACKAGE_MAINTAINER "The Seaway project <seaway@localhost>" CACHE STRING
  "Of the Debian packages: name and address of whoever hands them out")
set(CPACK_DEBIAN_PACKAGE_MAINTAINER ${SEAWAY_PACKAGE_MAINTAINER})
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_PACKAGE_DIRECTORY ${PROJECT_BINARY_DIR}/packages)
set(CPACK_INSTALL_PREFIX /usr)
set(CPACK_SET_DESTDIR ON) # configuration is in /etc
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_ALL server tools library development)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)

set(control ${PROJECT_SOURCE_DIR}/deploy/debian)
# Vulkan is loaded where it is there: no program is linked with it.
set(driver "libvulkan1, mesa-vulkan-drivers | vulkan-icd")
set(CPACK_DEBIAN_SERVER_PACKAGE_NAME seaway-server)
set(CPACK_COMPONENT_SERVER_DESCRIPTION "ocean simulation server
Computes the sea of a scene and streams it to thin clients as compressed
maps; answers what the water does at any point, at any time.")
set(CPACK_DEBIAN_SERVER_PACKAGE_DEPENDS adduser)
set(CPACK_DEBIAN_SERVER_PACKAGE_RECOMMENDS ${driver})
set(CPACK_DEBIAN_SERVER_PACKAGE_CONTROL_EXTRA
  ${control}/postinst ${control}/prerm ${control}/postrm ${control}/conffiles)

set(CPACK_DEBIAN_TOOLS_PACKAGE_NAME seaway-tools)
set(CPACK_COMPONENT_TOOLS_DESCRIPTION "programs that ask, draw and change a sea
Points and pictures of a running Seaway server, what a scene amounts to,
meshes and maps for other programs, and what all of that costs.")
set(CPACK_DEBIAN_TOOLS_PACKAGE_RECOMMENDS ${driver})

set(CPACK_DEBIAN_LIBRARY_PACKAGE_NAME libseaway${PROJECT_VERSION_MAJOR})
set(CPACK_DEBIAN_LIBRARY_PACKAGE_SECTION libs)
# By these, packages of programs that are linked with it say so, and the loader's cache knows it. Before 1.0 another minor
# version is another interface under the same name.
set(library libseaway${PROJECT_VERSION_MAJOR})
set(needed "${library} (>= ${PROJECT_VERSION})")
if(PROJECT_VERSION_MAJOR EQUAL 0)
  math(EXPR next_minor "${PROJECT_VERSION_MINOR} + 1")
  string(APPEND needed ", ${library} (<< 0.${next_minor}~)")
endif()
file(WRITE ${PROJECT_BINARY_DIR}/debian/shlibs "libseaway ${PROJECT_VERSION_MAJOR} ${needed}\n")
set(CPACK_DEBIAN_LIBRARY_PACKAGE_CONTROL_EXTRA ${PROJECT_BINARY_DIR}/debian/shlibs ${control}/triggers)
set(CPACK_COMPONENT_LIBRARY_DESCRIPTION "client of a Seaway server: the water at any point
A sea that a server computes, sampled in this process.")

set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME libseaway-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS
  "libseaway${PROJECT_VERSION_MAJOR} (= ${PROJECT_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE})")
set(CPACK_COMPONENT_DEVELOPMENT_DESCRIPTION "headers of Seaway's client library
For C and C++; found by pkg-config and by CMake's find_package(seaway).")

configure_file(${control}/changelog.in ${PROJECT_BINARY_DIR}/debian/changelog.Debian @ONLY)
execute_process(COMMAND gzip -9nf ${PROJECT_BINARY_DIR}/debian/changelog.Debian COMMAND_ERROR_IS_FATAL ANY)
foreach(component IN LISTS CPACK_COMPONENTS_ALL)
  string(TOUPPER ${component} upper)
  install(FILES ${control}/copyright ${PROJECT_BINARY_DIR}/debian/changelog.Debian.gz
    DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${CPACK_DEBIAN_${upper}_PACKAGE_NAME} COMPONENT ${component})
endforeach()
include(CPack)
