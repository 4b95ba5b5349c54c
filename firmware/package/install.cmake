# What the Debian package sanso-firmware holds (component firmware). Paths below /usr, and /etc for what its owner edits.
if(NOT TARGET sanso-firmware)
  return()
endif()
install(TARGETS sanso-firmware RUNTIME DESTINATION bin COMPONENT firmware)
install(FILES ${CMAKE_CURRENT_LIST_DIR}/sanso-firmware.service DESTINATION lib/systemd/system COMPONENT firmware)
install(FILES ${CMAKE_CURRENT_LIST_DIR}/60-sanso.rules DESTINATION lib/udev/rules.d COMPONENT firmware)
install(PROGRAMS ${CMAKE_CURRENT_LIST_DIR}/irq-priority DESTINATION lib/sanso COMPONENT firmware)
install(FILES ${CMAKE_CURRENT_LIST_DIR}/robot.toml DESTINATION /etc/sanso COMPONENT firmware)
install(FILES ${PROJECT_SOURCE_DIR}/docs/faults.md ${PROJECT_SOURCE_DIR}/docs/settings.md ${PROJECT_SOURCE_DIR}/docs/howto/robot.md
        DESTINATION share/doc/sanso-firmware COMPONENT firmware)
