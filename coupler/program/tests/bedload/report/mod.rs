//! The report page. The runs here are drawn from formulas, for the page's sake: they simulate nothing.

mod fields;
mod page;
mod sample;
