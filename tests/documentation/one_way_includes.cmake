# Fails when a file includes one of a folder to the right of its own: the order of the parts, and of the folders in the larger ones,
# as contact_core/documentation/architecture.md has them; and when a folder with sources has no place in its parent's order. The fit
# of meshes uses geometry alone; examples/own_backend, a project of its own, uses the suite that is installed.
# cmake -D ROOT=... -P one_way_includes.cmake
set(parents . contact_core contact_core/native contact_core/world physics physics/world adapters examples examples/bench
  examples/compare_backends examples/compare_backends/run examples/measures examples/program examples/station
  examples/training_run tests tests/proof tests/world)
set(folders_of_. contact_core physics adapters examples tests)
set(folders_of_contact_core memory threads geometry numerics narrowphase broadphase native edge_face scene motion mechanism world output fit)
set(folders_of_contact_core/native common simd solids overlap distance manifold engine)
set(folders_of_contact_core/world objects pairs model frame slide set_up)
set(folders_of_physics solver bodies joints world contacts scene engine guarded)
set(folders_of_physics/world groups rows islands step)
set(folders_of_adapters exact fcl libccd bullet bullet_plugin bullet_dynamics dart_plugin mujoco mujoco_plugin mujoco_dynamics
  ode ode_plugin ode_dynamics all cover_proof mesh_files robots urdf sdf mjcf robot_formats scene_files cigi gltf recorder
  c_interface c_files plugin process_engine python)
set(folders_of_examples measures program robot_files two_boxes stop_at_contact sliding_box own_backend first_table engine_check fit
  compare_backends training_run dynamics_run guarded_run station bench python)
set(folders_of_examples/bench corpus capture site candidates)
set(folders_of_examples/compare_backends judge run figures results diff fitted page cli)
set(folders_of_examples/compare_backends/run workers shards sets scenes)
set(folders_of_examples/measures common pairs truth paths runs accuracy)
set(folders_of_examples/program options terminal files plots)
set(folders_of_examples/station flight exchange messages server)
set(folders_of_examples/training_run setting flight results cli)
set(folders_of_tests support memory backend_suite measures motion mechanism world proof physics fit compare_backends benchmarks bench
  broadphase bullet bullet_plugin c_interface c_files dart_plugin documentation dynamics_run edge_face engine_check engines exact fcl
  geometry guarded_run hard_cases install libccd mesh_files mjcf mujoco_plugin mujoco narrowphase native numerics ode ode_plugin
  outputs plugin process_engine python robots rounded scene scene_files sdf station station_page training urdf)
set(folders_of_tests/proof pairs checks hash long_run corpus soak)
set(folders_of_tests/world arms frames slides set_up progress flown)

file(GLOB_RECURSE sources RELATIVE ${ROOT} ${ROOT}/contact_core/*.hpp ${ROOT}/contact_core/*.cpp ${ROOT}/physics/*.hpp
  ${ROOT}/physics/*.cpp ${ROOT}/adapters/*.hpp ${ROOT}/adapters/*.cpp ${ROOT}/examples/*.hpp ${ROOT}/examples/*.cpp
  ${ROOT}/tests/*.hpp ${ROOT}/tests/*.cpp)
set(backwards)
set(unplaced)
foreach(source IN LISTS sources)
  file(STRINGS ${ROOT}/${source} includes REGEX "^#include \"touchstone/")
  list(TRANSFORM includes REPLACE ".*\"touchstone/(.*)\".*" "\\1")
  if(source MATCHES "^contact_core/fit/")
    foreach(include IN LISTS includes)
      if(NOT include MATCHES "^contact_core/(fit/|geometry/|input_error)")
        string(APPEND backwards "\n  ${source} includes ${include}")
      endif()
    endforeach()
  endif()
  foreach(parent IN LISTS parents)
    set(below "^${parent}/([a-z_]+)/.*")
    if(parent STREQUAL ".")
      set(below "^([a-z_]+)/.*")
    endif()
    if(NOT source MATCHES "${below}")
      continue()
    endif()
    list(FIND folders_of_${parent} ${CMAKE_MATCH_1} own)
    if(own EQUAL -1)
      list(APPEND unplaced ${parent}/${CMAKE_MATCH_1})
      continue()
    endif()
    foreach(include IN LISTS includes)
      if(NOT include MATCHES "${below}" OR (source MATCHES "^examples/own_backend/" AND include MATCHES "^tests/backend_suite/"))
        continue()
      endif()
      list(FIND folders_of_${parent} ${CMAKE_MATCH_1} other)
      if(other GREATER own)
        string(APPEND backwards "\n  ${source} includes ${include}")
      endif()
    endforeach()
  endforeach()
endforeach()
if(unplaced)
  list(REMOVE_DUPLICATES unplaced)
  list(JOIN unplaced "\n  " unplaced)
  message(FATAL_ERROR "Without a place in the order of their parent's folders:\n  ${unplaced}")
endif()
if(NOT sources OR backwards)
  message(FATAL_ERROR "Against the order of the folders:${backwards}")
endif()
