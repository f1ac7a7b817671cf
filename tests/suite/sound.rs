//! Sound of short runs: levels, files, what is kept, what is refused.

use std::fs;
use std::path::Path;

use serde_json::Value;
use tyrewave::sound::wav::full_scale_of;

use crate::common::{loaded, run_into, tyrewave_with_cache};
