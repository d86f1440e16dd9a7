"""Bad inputs, injected faults, races and metamorphic relations: what the program does with them."""
