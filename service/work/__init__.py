"""What a request has computed: in processes that can be ended, in turns, and no longer than a request may take."""
