"""What bench/reproduce is made of: experiments (what is run), runs (running it), figures and tables (what is told of it)."""
