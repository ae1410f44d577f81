"""The tests that `make quick` and `make test-lowest` leave out."""

from __future__ import annotations

# Everything in these modules: browsers, cross-checks, wheels, documents, generated files.
MODULES = """
    test_against_yourdfpy test_crosscheck test_faults test_default_install test_docs_reference
    test_docs_site test_documents test_examples test_explanations test_mjcf_simulation test_arm
    test_ik_cli test_ik_compiling test_follow test_head test_kept test_leg test_legs
    test_ik_reference_cases test_whole_body test_installation test_joints_documents test_live test_meshes
    test_motion_cli test_files_written test_notebooks test_printed_output test_reach_cli test_reach_page
    test_reproduce_paper test_scripts test_signals test_resumed test_supervisor test_multidof_model
    test_multidof_random_robots test_multidof_whole_turns test_multidof_without_intermediate_links test_access
    test_browser test_viewer_cli test_closed_forms test_connection test_drag
    test_from_python test_viewer_lights test_meshcat test_notebook test_panel
    test_pointer test_seeing test_server test_standing test_timeline
    test_virtual_cartesian test_virtual_server test_virtual_walk test_virtual_whole_body test_wheel test_wrong_kinds
""".split()

# Single tests of the other modules.
TESTS = """
    test_of_processes_that_need_a_kernel_at_once_one_compiles_it_and_the_next_need_not
    test_a_short_program_is_answered_at_once_and_the_kernel_is_compiled_after_its_end
    test_warmup_says_what_is_ready_and_where
    test_a_narrow_terminal_cuts_nothing
    test_axes_of_a_merged_joint_meet_in_every_configuration
    test_every_robot_of_example_robot_data_loads_or_says_why
    test_yourdfpy_reads_it_without_a_warning
    test_pinocchio_reads_the_shapes
    test_every_version_composes
    test_a_shear_is_defective_and_has_one_jordan_block
    test_at_a_lock_and_beside_it_every_frame_comes_back
    test_romeo_shows_too
    test_romeo_is_exported_with_its_meshes
    test_other_shapes_are_refused
    test_the_identities_of_the_paper_hold_symbolically
    test_a_link_without_a_shape_colours_what_it_is_fixed_to
    test_check_urdf_accepts_it
    test_equal_robots_give_equal_pages
    test_the_program_runs_from_any_folder_and_reads_standard_input
    test_doctor_prints_what_it_found
    test_any_consistent_typed_configuration_has_a_way_back
    test_errors_leave_with_code_2_and_one_line
    test_hundreds_of_displays_do_not_grow_the_page_or_the_memory
    test_a_reader_that_stops_early_is_no_error
    test_at_a_singular_value_the_axes_span_a_plane_and_beside_it_space
    test_the_determinant_of_the_jordan_basis_is_the_cosine_or_one_over_the_lengths
    test_closed_streams_are_named_or_done_without
    test_plain_numbers_take_the_same_way_as_arrays
    test_the_second_foot_is_the_first_moved_along_the_normal_and_both_lie_on_their_lines
    test_the_library_loads_without_the_viewer
    test_a_misspelt_offset_is_seen_by_the_type_checker
    test_importing_the_package_loads_nothing_heavy
    test_a_pickle_lives_in_another_process
    test_a_warning_is_printed_once_as_one_line
    test_messages_repeat_little_of_what_was_given
    test_an_interrupt_ends_without_a_traceback
    test_the_program_of_the_documentation_runs
    test_programs_that_run_already_do_the_work_though_one_is_killed
    test_the_script_walks_and_draws_and_writes_a_clip
    test_view_writes_a_page_that_plays_the_motion
    test_plot_draws_a_png_and_an_svg
    test_without_numba_every_number_is_the_same
    test_the_suite_of_the_default_installation_passes_where_no_extra_is
""".split()


def is_slow(module: str, test: str) -> bool:
    """Whether a test, named without its parameters, is one of them."""
    return module in MODULES or test in TESTS
