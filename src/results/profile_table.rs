//! What a run cost, as tables for the terminal: stages first, counters below.

use std::time::Duration;

use comfy_table::{Cell, CellAlignment, LineStyle, Table, TableStyle};

use crate::meter::{Counter, Meter, Stage};

/// Stage times and counters as text, a newline last. `wall` is the time of the whole run; what no stage has is listed as the rest.
pub fn profile_table(meter: &Meter, wall: Duration) -> String {
    format!("{}\n\n{}\n", trimmed(&stages(meter, wall)), trimmed(&counters(meter)))
}

fn stages(meter: &Meter, wall: Duration) -> Table {
    let share = |part: Duration| {
        if wall.is_zero() { String::new() } else { format!("{:.1} %", 100.0 * part.as_secs_f64() / wall.as_secs_f64()) }
    };
    let seconds = |time: Duration| format!("{:.3} s", time.as_secs_f64());
    let mut table = table(["stage", "calls", "wall", "share"]);
    let mut staged = Duration::ZERO;
    for stage in Stage::ALL {
        let cost = meter.cost(stage);
        staged += cost.wall;
        add(&mut table, [stage.title().to_owned(), grouped(cost.calls), seconds(cost.wall), share(cost.wall)]);
    }
    let rest = wall.saturating_sub(staged);
    add(&mut table, ["everything else".to_owned(), String::new(), seconds(rest), share(rest)]);
    add(&mut table, ["whole run".to_owned(), String::new(), seconds(wall), share(wall)]);
    table
}

fn counters(meter: &Meter) -> Table {
    let mut table = table(["counter", "amount"]);
    for counter in Counter::ALL {
        add(&mut table, [counter_title(counter).to_owned(), grouped(meter.counted(counter))]);
    }
    table
}

/// The counter named as people read it in a table.
const fn counter_title(counter: Counter) -> &'static str {
    match counter {
        Counter::ComplianceEvaluations => "compliance evaluations",
        Counter::Poles => "poles of the influence functions",
        Counter::HistoryMultiplyAdds => "history multiply-adds",
        Counter::Slices => "road slices",
        Counter::Steps => "time steps",
        Counter::Solves => "linear solves",
        Counter::Factorisations => "factorisations",
        Counter::CacheHits => "factor cache hits",
        Counter::CacheMisses => "factor cache misses",
        Counter::CacheEvictions => "factor cache evictions",
        Counter::Fallbacks => "least-index fallbacks",
        Counter::WindowEdgeContacts => "steps with contact at the window's edge",
        Counter::BytesWritten => "bytes written",
    }
}

fn table<const N: usize>(header: [&str; N]) -> Table {
    let mut table = Table::new();
    table.load_style(TableStyle::new().header_separator(LineStyle::none().fill('─').junction('─')));
    table.set_header(header.iter().enumerate().map(|(column, title)| cell(column, (*title).to_owned())));
    table
}

fn add<const N: usize>(table: &mut Table, row: [String; N]) {
    table.add_row(row.into_iter().enumerate().map(|(column, text)| cell(column, text)).collect::<Vec<_>>());
}

/// Words to the left, numbers to the right.
fn cell(column: usize, text: String) -> Cell {
    Cell::new(text).set_alignment(if column == 0 { CellAlignment::Left } else { CellAlignment::Right })
}

fn trimmed(table: &Table) -> String {
    table.lines().map(|line| line.trim_end().to_owned()).collect::<Vec<_>>().join("\n")
}

/// A number with thin groups of three: 21 233 664.
fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let groups: Vec<&str> = (0..digits.len())
        .filter(|position| *position == 0 || (digits.len() - position).is_multiple_of(3))
        .map(|position| {
            let end = position + if position == 0 { (digits.len() - 1) % 3 + 1 } else { 3 };
            &digits[position..end]
        })
        .collect();
    groups.join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thousands_are_grouped() {
        let cases = [
            (0, "0"),
            (12, "12"),
            (999, "999"),
            (1000, "1 000"),
            (21_233_664, "21 233 664"),
            (u64::MAX, "18 446 744 073 709 551 615"),
        ];
        for (number, text) in cases {
            assert_eq!(grouped(number), text);
        }
    }

    #[test]
    fn every_stage_and_counter_is_listed_and_shares_add_up() {
        let mut meter = Meter::default();
        meter.add_time(Stage::History, Duration::from_millis(1500));
        meter.add_time(Stage::History, Duration::from_millis(500));
        meter.count(Counter::HistoryMultiplyAdds, 21_233_664);
        let text = profile_table(&meter, Duration::from_secs(4));
        println!("{text}");
        for stage in Stage::ALL {
            assert!(text.contains(stage.title()), "{text}");
        }
        for counter in Counter::ALL {
            assert!(text.contains(counter_title(counter)), "{text}");
        }
        assert!(text.contains("2.000 s") && text.contains("50.0 %") && text.contains("21 233 664"), "{text}");
        assert!(text.lines().any(|line| line.contains("everything else") && line.contains("50.0 %")), "{text}");
        let none = profile_table(&Meter::default(), Duration::ZERO);
        assert!(!none.contains("NaN"), "{none}");
    }
}
