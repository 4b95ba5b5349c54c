# Debian packages: `cpack --config build/release/CPackConfig.cmake` makes sanso-firmware and sanso; a cross build makes the first.
# A top-level include, after every install() rule.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME sanso)
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_PACKAGE_CONTACT "sanso maintainers <maintainers@sanso.invalid>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "whole-body control of a position-controlled humanoid")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
    OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)

set(CPACK_COMPONENTS_ALL firmware)
set(CPACK_DEBIAN_FIRMWARE_PACKAGE_NAME sanso-firmware)
set(CPACK_DEBIAN_FIRMWARE_PACKAGE_SECTION electronics)
set(CPACK_COMPONENT_FIRMWARE_DESCRIPTION "The onboard controller of the robot OP3: reads servos and IMU, adds up the
 three layers of the policy and writes the servos' goals every 10 ms; keeps
 the robot safe when anything of that fails.")
set(package_folder ${PROJECT_SOURCE_DIR}/firmware/package)
set(CPACK_DEBIAN_FIRMWARE_PACKAGE_CONTROL_EXTRA
    ${package_folder}/postinst ${package_folder}/prerm ${package_folder}/postrm ${package_folder}/conffiles)
set(firmware_depends "adduser")
if(CMAKE_CROSSCOMPILING)
  # dpkg-shlibdeps knows the libraries of this machine only; the versions are those of Debian 12
  set(CPACK_DEBIAN_PACKAGE_ARCHITECTURE arm64)
  string(APPEND firmware_depends ", libc6 (>= 2.36), libgcc-s1 (>= 3.0), libhidapi-libusb0 (>= 0.13.1), libsodium23 (>= 1.0.18)"
         ", libstdc++6 (>= 12), libusb-1.0-0 (>= 2:1.0.26), libyaml-0-2, libzstd1 (>= 1.5.4)")
else()
  set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
  list(APPEND CPACK_COMPONENTS_ALL host)
endif()
set(CPACK_DEBIAN_FIRMWARE_PACKAGE_DEPENDS "${firmware_depends}")
set(CPACK_DEBIAN_FIRMWARE_PACKAGE_RECOMMENDS libhidapi-hidraw0)  # loaded at run time for hidapi-hidraw:

set(CPACK_DEBIAN_HOST_PACKAGE_NAME sanso)
set(CPACK_DEBIAN_HOST_PACKAGE_SECTION science)
set(CPACK_COMPONENT_HOST_DESCRIPTION "The host's tools: plan and learn motions for a robot that runs
 sanso-firmware, or for an emulated one, and find from recordings the physics
 that a simulation misses.")
set(CPACK_DEBIAN_HOST_PACKAGE_SUGGESTS "sanso-firmware")

# What every package has to say of itself.
function(sanso_package_papers package component)
  set(folder ${PROJECT_BINARY_DIR}/package/${package})
  string(TIMESTAMP date "%a, %d %b %Y %H:%M:%S +0000" UTC)
  file(WRITE ${folder}/changelog
"${package} (${PROJECT_VERSION}) bookworm; urgency=medium

  * Version ${PROJECT_VERSION}; what changed for users: CHANGELOG.md of the source.

 -- ${CPACK_PACKAGE_CONTACT}  ${date}
")
  execute_process(COMMAND gzip -9nf ${folder}/changelog COMMAND_ERROR_IS_FATAL ANY)
  file(WRITE ${folder}/copyright
"Format: https://www.debian.org/doc/packaging-manuals/copyright-format/1.0/
Upstream-Name: sanso

Files: *
Copyright: 2026 the sanso contributors
License: Apache-2.0
 On Debian systems the text of this license is in
 /usr/share/common-licenses/Apache-2.0.
")
  install(FILES ${folder}/changelog.gz ${folder}/copyright DESTINATION share/doc/${package} COMPONENT ${component})
endfunction()

# A manual page: sanso_manual(file section component)
function(sanso_manual page section component)
  get_filename_component(name ${page} NAME)
  file(MAKE_DIRECTORY ${PROJECT_BINARY_DIR}/package/man)
  execute_process(COMMAND gzip -9nc ${page} OUTPUT_FILE ${PROJECT_BINARY_DIR}/package/man/${name}.gz COMMAND_ERROR_IS_FATAL ANY)
  install(FILES ${PROJECT_BINARY_DIR}/package/man/${name}.gz DESTINATION share/man/man${section} COMPONENT ${component})
endfunction()

if(TARGET sanso-firmware)
  sanso_package_papers(sanso-firmware firmware)
  sanso_manual(${package_folder}/sanso-firmware.8 8 firmware)
endif()
if(TARGET sanso)
  sanso_package_papers(sanso host)
  set(host_folder ${PROJECT_SOURCE_DIR}/tools/sanso/package)
  sanso_manual(${host_folder}/sanso.1 1 host)
  sanso_manual(${host_folder}/sanso-emulator.1 1 host)
  install(TARGETS sanso sanso-emulator RUNTIME DESTINATION bin COMPONENT host)
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/host/motion/library/ DESTINATION share/sanso/motions COMPONENT host)
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/tools/plant/worlds DESTINATION share/sanso COMPONENT host)
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/tools/export/layouts DESTINATION share/sanso COMPONENT host)
  install(FILES ${host_folder}/completion.bash DESTINATION share/bash-completion/completions RENAME sanso COMPONENT host)
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/docs/howto DESTINATION share/doc/sanso COMPONENT host FILES_MATCHING PATTERN "*.md")
endif()
if(TARGET sanso-firmware)
  include(CPack)
endif()
