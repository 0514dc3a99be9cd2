//! The keywords of JSON Schema that the schema of scene files has.

use serde_json::Value;

/// Returns the violations of the schema in `value`, each with its place.
pub fn faults(schema: &Value, value: &Value) -> Vec<String> {
    let mut found = Vec::new();
    check(schema, value, String::new(), &mut found);
    found
}

fn check(schema: &Value, value: &Value, place: String, found: &mut Vec<String>) {
    if let Some(choices) = schema.get("anyOf").and_then(Value::as_array) {
        let of_each = choices.iter().map(|choice| {
            let mut faults = Vec::new();
            check(choice, value, place.clone(), &mut faults);
            faults
        });
        // The choice that is understood furthest has the fault.
        let best = of_each.min_by_key(|faults| {
            let depth = |fault: &String| fault.split(':').next().map_or(0, |place| place.matches('/').count());
            (
                !faults.is_empty(),
                usize::MAX - faults.iter().map(depth).max().unwrap_or(0),
            )
        });
        found.extend(best.unwrap_or_default());
        return;
    }
    if let Some(names) = schema.get("enum").and_then(Value::as_array)
        && !names.contains(value)
    {
        found.push(format!("{place}: none of {names:?}"));
    }
    let is = |name: &str| match name {
        "object" => value.is_object(),
        "array" => value.is_array(),
        "string" => value.is_string(),
        "boolean" => value.is_boolean(),
        "integer" => value.is_i64() || value.is_u64(),
        "number" => value.is_number(),
        other => panic!("no type is called {other}"),
    };
    if let Some(name) = schema.get("type").and_then(Value::as_str)
        && !is(name)
    {
        found.push(format!("{place}: no {name}"));
        return;
    }
    if let Some(table) = value.as_object() {
        let required = schema.get("required").and_then(Value::as_array);
        for key in required.into_iter().flatten().filter_map(Value::as_str) {
            if !table.contains_key(key) {
                found.push(format!("{place}/{key}: missing"));
            }
        }
        for (key, value) in table {
            let place = format!("{place}/{key}");
            let known = schema.get("properties").and_then(|properties| properties.get(key));
            match (known, schema.get("additionalProperties")) {
                (Some(inner), _) => check(inner, value, place, found),
                (None, Some(Value::Bool(false))) => found.push(format!("{place}: unknown")),
                (None, Some(inner)) => check(inner, value, place, found),
                (None, None) => {}
            }
        }
    }
    if let Some(list) = value.as_array() {
        let limit = |name: &str| schema.get(name).and_then(Value::as_u64);
        let count = list.len() as u64;
        if limit("minItems").is_some_and(|least| count < least) || limit("maxItems").is_some_and(|most| count > most) {
            found.push(format!("{place}: {count} items"));
        }
        if let Some(inner) = schema.get("items") {
            for (i, value) in list.iter().enumerate() {
                check(inner, value, format!("{place}/{i}"), found);
            }
        }
    }
}
