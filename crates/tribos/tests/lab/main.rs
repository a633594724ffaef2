//! `tribos lab` in a headless browser, and without one; the page without installation. `PICTURES=DIR cargo test -p tribos --test lab` keeps pictures.

#[macro_use]
extern crate untested;

mod access;
mod analysis;
mod browser;
#[cfg(unix)]
#[path = "../shared/cable.rs"]
mod cable;
mod cost;
mod experiments;
mod handover;
#[cfg(unix)]
mod origin;
mod plane;
mod scope;
mod without_installation;

use browser::CHROMIUM;
use std::process::ExitCode;

fn main() -> ExitCode {
    untested::run!(
        tests![
            access::pages_of_other_origins_can_neither_read_nor_command,
            access::beyond_loopback_nobody_comes_in_without_the_token,
            access::no_path_leads_out_of_the_folder,
            access::a_flood_of_requests_is_refused_and_stop_is_not,
            access::ten_thousand_malformed_messages_crash_nothing,
            access::batches_of_ones_own_are_presented_and_what_the_device_would_refuse_is_refused_before_the_first_trial,
            origin::a_virtual_device_on_a_port_is_homed_by_itself,
            origin::a_real_device_is_homed_only_when_the_page_asks,
            handover::what_was_recorded_is_diagnosed_and_felt_on_the_handle,
            experiments::a_driven_handle_is_let_go_within_seconds_of_the_labs_death,
        ],
        tests![access::a_hundred_thousand_malformed_messages_crash_nothing]
            .on_demand("half a minute; the short form is always run"),
        tests![
            access::a_malicious_page_in_a_real_browser_gets_nothing,
            analysis::what_the_device_would_refuse_cannot_be_sent_and_is_explained,
            analysis::a_move_is_recorded_identified_and_its_report_opens_beside,
            experiments::a_segment_of_targeting_and_a_batch_of_forced_choice_by_script,
            experiments::what_is_finished_survives_the_death_of_server_browser_and_device,
            experiments::a_pulled_cable_is_told_in_plain_words_and_finished_trials_are_kept,
            handover::three_clicks_lead_from_a_recording_to_the_handle,
            plane::the_force_of_a_dragged_puck_is_that_of_the_law,
            plane::a_circle_of_targets_is_selected_kept_and_analysed,
            scope::the_trace_is_live_at_1_khz_and_rubber_feels_like_rubber,
            scope::a_fault_is_told_in_plain_words_and_cleared_from_the_page,
            scope::a_picture_of_a_minute_shows_the_one_sample_that_stands_out_and_the_gap,
        ]
        .needing(&CHROMIUM),
        tests![
            without_installation::a_file_is_diagnosed_as_the_command_does,
            without_installation::a_bad_cell_is_refused_in_the_words_of_the_command,
            without_installation::nothing_leaves_the_machine_and_a_bug_is_told,
            without_installation::twenty_five_thousand_samples_are_timed_and_cancelled,
        ]
        .needing(&without_installation::PAGE),
        tests![scope::the_trace_is_live_for_a_minute]
            .needing(&CHROMIUM)
            .on_demand("a minute; the short form is always run"),
    )
}
