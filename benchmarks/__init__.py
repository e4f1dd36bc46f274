"""What README's speed table is made with: ratios against a peer in the same run."""
